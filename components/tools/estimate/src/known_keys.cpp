// SPDX-License-Identifier: Apache-2.0
#include "known_keys.hpp"

#include "pipescout/files/yaml_location.hpp"

namespace pipescout::estimate {

void require_known_keys(const YAML::Node& node, const std::set<std::string>& known,
                        const std::string& file) {
  if (!node.IsMap()) {
    throw YamlError(file, node.Mark(), "a mapping of keys and values is expected");
  }
  for (const auto& each : node) {
    if (!known.contains(each.first.Scalar())) {
      throw YamlError(file, each.first.Mark(), "unknown key '" + each.first.Scalar() + "'");
    }
  }
}

}  // namespace pipescout::estimate
