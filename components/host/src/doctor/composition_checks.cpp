// SPDX-License-Identifier: Apache-2.0
#include "doctor/checks.hpp"

namespace pipescout::host::doctor {

std::vector<Finding> check_components(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& trial : seen.trials) {
    if (!trial.failure.empty()) {
      findings.push_back({Severity::kError,
                          trial.location + ": " + trial.node.fully_qualified() +
                              " cannot be started: " + trial.failure,
                          "Mend what it names; the composition does not run before."});
    }
  }
  return findings;
}

std::vector<Finding> check_parameters(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& trial : seen.trials) {
    for (const auto& unused : trial.unused_parameters) {
      if (!unused.parameter.from_wildcard) {
        findings.push_back({Severity::kError,
                            to_string(unused) + " Component " + trial.node.fully_qualified() +
                                " does not declare it.",
                            "Correct the name, or take the line out: `pipescout param list` shows "
                            "what there is."});
      }
    }
  }
  return findings;
}

}  // namespace pipescout::host::doctor
