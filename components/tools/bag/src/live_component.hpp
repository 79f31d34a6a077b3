// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipescout/runtime/node.hpp"

namespace pipescout::bag_command {

/// A component that a command runs, found by its class: this executable links none.
struct LiveComponent {
  std::string class_name;
  std::string node_name;
  std::vector<ParameterOverride> parameters;
  RemapRules remap_rules;
  /// Called with a hidden node beside the component, once that is active; what it returns is kept
  /// until the component is taken down.
  std::function<std::shared_ptr<void>(Node& node)> attend;
};

/// Runs it on the network until SIGINT, SIGTERM or SIGHUP, or until it says that it is complete;
/// takes it down within two seconds. Returns the exit code; why it is not 0 is on stderr.
[[nodiscard]] int run_live(LiveComponent live);

/// For `LiveComponent::parameters`.
[[nodiscard]] ParameterOverride override_of(const char* name, ParameterValue value);

}  // namespace pipescout::bag_command
