// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <set>
#include <string>

namespace pipescout::estimate {

/// Throws YamlError, with the position in `file`, unless the node is a mapping of these keys only.
void require_known_keys(const YAML::Node& node, const std::set<std::string>& known,
                        const std::string& file);

}  // namespace pipescout::estimate
