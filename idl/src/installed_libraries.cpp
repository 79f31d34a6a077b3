// SPDX-License-Identifier: Apache-2.0
#include "installed_libraries.hpp"

#include <dlfcn.h>

#include <fstream>

#include "built_in_packages.hpp"

namespace pipescout::idl {
namespace {

std::string last_library_error() {
  const char* const error = dlerror();
  return error != nullptr ? error : "unknown error";
}

}  // namespace

std::filesystem::path library_list(const std::filesystem::path& prefix,
                                   const std::string& package) {
  return prefix / "share/ament_index/resource_index/pipescout_messages" / package;
}

std::vector<LibraryEntry> read_library_list(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<LibraryEntry> entries;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (line.empty()) {
      continue;
    }
    const auto semicolon = line.find(';');
    if (semicolon == std::string::npos || semicolon == 0 || semicolon + 1 == line.size()) {
      throw MessageTypeError(file.string() + ":" + std::to_string(number) +
                             ": expected TYPE;LIBRARY, found '" + line + "'");
    }
    entries.push_back({line.substr(0, semicolon), line.substr(semicolon + 1)});
  }
  if (!stream.eof()) {
    throw MessageTypeError(file.string() + ": cannot be read");
  }
  return entries;
}

std::span<const ObjectType* const> load_library(const std::filesystem::path& library,
                                                const std::string& package) {
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    throw MessageTypeError("library with the messages of " + package +
                           " cannot be loaded: " + last_library_error());
  }
  const auto symbol = "pipescout_message_objects_of_" + package;
  const auto list = reinterpret_cast<ListObjects>(dlsym(handle, symbol.c_str()));
  if (list == nullptr) {
    throw MessageTypeError(library.string() + " holds no messages of " + package +
                           ": it has no symbol " + symbol);
  }
  const auto objects = list();
  return {objects.types, objects.count};
}

}  // namespace pipescout::idl
