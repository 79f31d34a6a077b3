// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace YAML {
class Node;
}

/// Texts of the keys of a YAML map. Each throws YamlError, with the position in the file `path`,
/// for what is no text, or an empty one.
namespace pipescout::command_line {

/// Nothing when the map has no such key.
[[nodiscard]] std::optional<std::string> map_text(const YAML::Node& map, const std::string& key,
                                                  const std::string& path);
/// A missing key is an error too.
[[nodiscard]] std::string required_map_text(const YAML::Node& map, const std::string& key,
                                            const std::string& path);
/// One text or a list of texts, at least one; a missing key is an error.
[[nodiscard]] std::vector<std::string> map_texts(const YAML::Node& map, const std::string& key,
                                                 const std::string& path);

}  // namespace pipescout::command_line
