// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "pipescout/keystore/policy.hpp"

/// What running processes use, seen from the network.
namespace pipescout::security {

struct ObservationRequest {
  /// The words behind `pipescout run`; empty: what runs already.
  std::vector<std::string> composition;
  /// In which the composition runs; empty: its own.
  std::string ns;
  /// Instead of the enclaves that the processes announce; empty: those.
  std::string enclave;
  /// How long nothing new must come before the system counts as complete.
  std::chrono::milliseconds quiet{3000};
  std::chrono::seconds at_most{60};
};

/// Throws CommandError when nothing is seen, or the composition ends with an error before; the
/// error then has what it printed.
[[nodiscard]] keystore::Policy observe(const ObservationRequest& request);

}  // namespace pipescout::security
