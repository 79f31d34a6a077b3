// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace pipescout::host {

/// The names of a kind, which is the name that commands give to their arguments: types, packages
/// and component classes ("plugin") of this installation; nodes, containers, topics, services and
/// actions of the running system, as many as are found within a second. None of a kind that it does
/// not know. Throws what Session throws.
[[nodiscard]] std::vector<std::string> completion_names(const std::string& kind);

}  // namespace pipescout::host
