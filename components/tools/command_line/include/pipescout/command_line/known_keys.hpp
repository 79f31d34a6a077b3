// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace YAML {
class Node;
}

namespace pipescout::command_line {

/// Throws YamlError, with the position in the file `path`, unless `map` is a YAML map that has no
/// other keys than `known`. `what` it is opens the message: "an entry of 'export'".
void require_known_keys(const YAML::Node& map, const std::string& path, const std::string& what,
                        const std::vector<std::string>& known);

}  // namespace pipescout::command_line
