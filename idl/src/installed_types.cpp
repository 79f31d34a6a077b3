// SPDX-License-Identifier: Apache-2.0
#include "installed_types.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <span>
#include <system_error>
#include <utility>

#include "built_in_packages.hpp"
#include "pipescout/idl/installed_prefixes.hpp"

namespace pipescout::idl {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kIndex = "share/ament_index/resource_index/pipescout_messages";

struct Entry {
  std::string type;
  std::string library;  ///< relative to the prefix
};

/// Throws MessageTypeError.
std::vector<Entry> read_list(const fs::path& file) {
  std::ifstream stream(file);
  std::vector<Entry> entries;
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

/// "package/msg/Type" with nothing in it that would lead elsewhere as a path.
bool is_type_name(std::string_view name) {
  return std::ranges::count(name, '/') == 2 && !name.starts_with('/') &&
         std::ranges::all_of(name, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '/';
         });
}

std::string last_library_error() {
  const char* const error = dlerror();
  return error != nullptr ? error : "unknown error";
}

std::span<const MessageType* const> load_library(const fs::path& library,
                                                 const std::string& package) {
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    throw MessageTypeError("library with the messages of " + package +
                           " cannot be loaded: " + last_library_error());
  }
  const auto symbol = "pipescout_message_types_of_" + package;
  const auto list = reinterpret_cast<ListTypes>(dlsym(handle, symbol.c_str()));
  if (list == nullptr) {
    throw MessageTypeError(library.string() + " holds no messages of " + package +
                           ": it has no symbol " + symbol);
  }
  const auto types = list();
  return {types.types, types.count};
}

}  // namespace

InstalledTypes& InstalledTypes::instance() {
  static auto* const types = new InstalledTypes;
  return *types;
}

const MessageType& InstalledTypes::load(std::string_view name) {
  const std::lock_guard lock(mutex_);
  if (const auto known = loaded_.find(name); known != loaded_.end()) {
    return *known->second;
  }
  if (!is_type_name(name)) {
    throw MessageTypeError("'" + std::string(name) + "' is no type name: package/msg/Type");
  }
  const std::string package(name.substr(0, name.find('/')));
  for (const auto& prefix : installed_prefixes()) {
    const auto file = prefix / kIndex / package;
    std::error_code error;
    if (!fs::is_regular_file(file, error)) {
      continue;
    }
    const auto entries = read_list(file);
    const auto entry = std::ranges::find(entries, name, &Entry::type);
    if (entry == entries.end()) {
      throw MessageTypeError("unknown type '" + std::string(name) + "': " + file.string() +
                             " does not list it");
    }
    const auto library = prefix / entry->library;
    for (const auto* const type : load_library(library, package)) {
      loaded_.emplace(type->name, type);
    }
    const auto loaded = loaded_.find(name);
    if (loaded == loaded_.end()) {
      throw MessageTypeError("unknown type '" + std::string(name) + "': " + library.string() +
                             " does not hold it, though " + file.string() + " says so");
    }
    return *loaded->second;
  }
  throw MessageTypeError("unknown type '" + std::string(name) + "': no package " + package +
                         " with messages is installed; is its prefix in AMENT_PREFIX_PATH?");
}

std::vector<std::string> InstalledTypes::list() {
  std::vector<std::string> names;
  std::set<std::string> packages;
  for (const auto& prefix : installed_prefixes()) {
    std::error_code error;
    for (fs::directory_iterator file(prefix / kIndex, error), end; !error && file != end;
         file.increment(error)) {
      if (!packages.insert(file->path().filename().string()).second) {
        continue;
      }
      try {
        for (auto& entry : read_list(file->path())) {
          names.push_back(std::move(entry.type));
        }
      } catch (const MessageTypeError&) {
        // Whoever asks for a type of that package is told.
      }
    }
  }
  return names;
}

}  // namespace pipescout::idl
