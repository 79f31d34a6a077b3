// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace pipescout::host {

/// What `complete` asks for: types and packages of this installation; nodes, containers, topics and
/// services of the running system, as many as are found within a second. Throws what Session
/// throws.
[[nodiscard]] std::vector<std::string> completion_names(const std::string& kind);

}  // namespace pipescout::host
