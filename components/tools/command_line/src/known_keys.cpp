// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/known_keys.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "pipescout/command_line/suggestion.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::command_line {
namespace {

std::string listed(const std::vector<std::string>& keys) {
  std::string list;
  for (const std::string& key : keys) {
    list += (list.empty() ? "" : ", ") + key;
  }
  return list;
}

}  // namespace

void require_known_keys(const YAML::Node& map, const std::string& path, const std::string& what,
                        const std::vector<std::string>& known) {
  if (!map.IsMap()) {
    throw YamlError(path, map.Mark(), what + " must be a map with the keys " + listed(known));
  }
  for (const auto& entry : map) {
    const std::string& key = entry.first.Scalar();
    if (std::ranges::find(known, key) == known.end()) {
      throw YamlError(path, entry.first.Mark(),
                      "unknown key '" + key + "' in " + what + suggestion(key, known) +
                          " (known: " + listed(known) + ")");
    }
  }
}

}  // namespace pipescout::command_line
