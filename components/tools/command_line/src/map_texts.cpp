// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/map_texts.hpp"

#include <yaml-cpp/yaml.h>

#include "pipescout/files/yaml_location.hpp"

namespace pipescout::command_line {

std::optional<std::string> map_text(const YAML::Node& map, const std::string& key,
                                    const std::string& path) {
  const auto node = map[key];
  if (!node) {
    return std::nullopt;
  }
  if (!node.IsScalar() || node.Scalar().empty()) {
    throw YamlError(path, node.Mark(), key + " must be a text");
  }
  return node.Scalar();
}

std::string required_map_text(const YAML::Node& map, const std::string& key,
                              const std::string& path) {
  auto text = map_text(map, key, path);
  if (!text) {
    throw YamlError(path, map.Mark(), "key '" + key + "' is missing");
  }
  return *std::move(text);
}

std::vector<std::string> map_texts(const YAML::Node& map, const std::string& key,
                                   const std::string& path) {
  const auto node = map[key];
  if (!node || node.IsScalar()) {
    return {required_map_text(map, key, path)};
  }
  std::vector<std::string> texts;
  if (node.IsSequence()) {
    for (const auto& entry : node) {
      if (!entry.IsScalar() || entry.Scalar().empty()) {
        throw YamlError(path, node.Mark(), key + " must be a text or a list of texts");
      }
      texts.push_back(entry.Scalar());
    }
  }
  if (texts.empty()) {
    throw YamlError(path, node.Mark(), key + " must be a text or a list of texts");
  }
  return texts;
}

}  // namespace pipescout::command_line
