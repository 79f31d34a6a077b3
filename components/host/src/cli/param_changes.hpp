// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "cli/session.hpp"

namespace pipescout::host {

/// The commands `param set`, `delete` and `load`.
void add_param_changes(CLI::App& group, Action& action);

/// Asks a node to set a parameter, or to delete it when the value is not set. Throws CommandError
/// when it does not answer.
[[nodiscard]] SetResult set_parameter(Session& session, const NodeName& node,
                                      const NamedParameter& parameter);

}  // namespace pipescout::host
