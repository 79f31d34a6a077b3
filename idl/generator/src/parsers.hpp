// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "model.hpp"

namespace pipescout::generator {

/// What the path of a definition file, PACKAGE/FOLDER/Name.EXTENSION, says about it.
struct DefinitionPath {
  std::string package;
  InterfaceKind kind = InterfaceKind::kMessage;
  std::string name;
  std::string file;  ///< to open, and for messages
};

/// An .idl file in the subset that rosidl reads. Throws DefinitionError.
[[nodiscard]] Interface parse_idl(std::string_view text, const DefinitionPath& path);

/// A .msg, .srv or .action file, according to `path.kind`. Throws DefinitionError.
[[nodiscard]] Interface parse_msg(std::string_view text, const DefinitionPath& path);

}  // namespace pipescout::generator
