// SPDX-License-Identifier: Apache-2.0
#include "doctor/checks.hpp"

#include <algorithm>
#include <iterator>

namespace pipescout::host::doctor {
namespace {

constexpr Check kChecks[] = {
    {"components", check_components},
    {"parameters", check_parameters},
    {"network", check_network},
    {"localhost-only", check_localhost_only},
    {"discovery", check_discovery},
    {"node-names", check_node_names},
    {"types", check_types},
    {"quality-of-service", check_quality_of_service},
    {"inputs", check_inputs},
    {"clock-publishers", check_clock_publishers},
    {"stamps", check_stamps},
    {"imu", check_imu},
    {"gps", check_gps},
    {"datum", check_datum},
    {"camera-calibration", check_camera_calibration},
    {"shared-memory", check_shared_memory},
    {"disk", check_disk},
};

std::string counted(std::size_t count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace

std::span<const Check> all_checks() {
  return kChecks;
}

std::vector<Finding> examine(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& check : kChecks) {
    auto found = check.run(seen);
    findings.insert(findings.end(), std::make_move_iterator(found.begin()),
                    std::make_move_iterator(found.end()));
  }
  return findings;
}

bool has_errors(const std::vector<Finding>& findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return finding.severity == Severity::kError; });
}

std::string report(const std::vector<Finding>& findings) {
  std::string text;
  for (const auto& finding : findings) {
    text += finding.severity == Severity::kError ? "error: " : "warning: ";
    text += finding.what + "\n  " + finding.advice + "\n";
  }
  const auto errors = static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(),
                    [](const Finding& finding) { return finding.severity == Severity::kError; }));
  return text + counted(errors, "error") + ", " + counted(findings.size() - errors, "warning") +
         " from " + counted(std::size(kChecks), "check") + "\n";
}

}  // namespace pipescout::host::doctor
