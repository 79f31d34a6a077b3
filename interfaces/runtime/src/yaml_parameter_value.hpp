// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/files/yaml_location.hpp"
#include "pipescout/runtime/parameter_value.hpp"

namespace pipescout {

/// A scalar or a sequence of scalars as a parameter value; honours quotes and the tags !!str,
/// !!bool, !!int, !!float and !!binary. Throws YamlError for null, maps, nested or mixed sequences
/// and numbers out of range.
[[nodiscard]] ParameterValue read_parameter_value(const YAML::Node& node, const std::string& path);

}  // namespace pipescout
