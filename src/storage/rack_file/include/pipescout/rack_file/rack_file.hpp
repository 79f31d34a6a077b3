// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/rack_vision/rack_model.hpp>
#include <string>

/// The file that describes a rack: docs/rack_file.md.
namespace pipescout {

/// Reads a rack and validates it. Its pipes are those of the row, from left to right, then the
/// others in the order of the file, then the vessels. Throws YamlError
/// (pipescout/files/yaml_location.hpp) naming file, line and column: a file that cannot be read or
/// is not YAML; unknown or missing fields, wrong types, numbers that are not finite; and everything
/// that RackModel::validate refuses, at the line of the pipe or support.
[[nodiscard]] rack_vision::RackModel read_rack(const std::string& path);

/// The same from a text. `path` names it in errors.
[[nodiscard]] rack_vision::RackModel parse_rack(const std::string& text, const std::string& path);

}  // namespace pipescout
