// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pipescout/idl/message_type.hpp"
#include "pipescout/idl/support/object_type.hpp"

/// Packages whose types were generated and compiled into a library of their own.
namespace pipescout::idl {

struct LibraryEntry {
  std::string type;
  std::string library;  ///< relative to the prefix
};

/// Where the list of a package's types is in a prefix.
[[nodiscard]] std::filesystem::path library_list(const std::filesystem::path& prefix,
                                                 const std::string& package);

/// Throws MessageTypeError.
[[nodiscard]] std::vector<LibraryEntry> read_library_list(const std::filesystem::path& file);

/// The types of the package that the library holds; it is never unloaded. Throws MessageTypeError.
[[nodiscard]] std::span<const ObjectType* const> load_library(const std::filesystem::path& library,
                                                              const std::string& package);

}  // namespace pipescout::idl
