// SPDX-License-Identifier: Apache-2.0
#include "installed_types.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "built_in_packages.hpp"
#include "definition_error.hpp"
#include "definitions.hpp"
#include "installed_definitions.hpp"
#include "installed_libraries.hpp"
#include "loaded_type.hpp"
#include "names.hpp"
#include "pipescout/idl/installed_prefixes.hpp"

namespace pipescout::idl {
namespace {

/// "package/msg/Type" with nothing in it that would lead elsewhere as a path.
bool is_type_name(std::string_view name) {
  return std::ranges::count(name, '/') == 2 && !name.starts_with('/') &&
         std::ranges::all_of(name, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '/';
         });
}

bool is_file(const std::filesystem::path& file) {
  std::error_code error;
  return std::filesystem::is_regular_file(file, error);
}

[[noreturn]] void refuse(std::string_view name, const std::string& reason) {
  throw MessageTypeError("unknown type '" + std::string(name) + "': " + reason);
}

/// Calls `use` with the path of each list of packages that the prefix has in that index.
template <class Use>
void for_each_list(const std::filesystem::path& index, Use use) {
  std::error_code error;
  for (std::filesystem::directory_iterator file(index, error), end; !error && file != end;
       file.increment(error)) {
    use(file->path());
  }
}

}  // namespace

InstalledTypes& InstalledTypes::instance() {
  static auto* const types = new InstalledTypes;
  return *types;
}

InstalledTypes::InstalledTypes() {
  for (const auto& package : built_in_packages()) {
    const auto objects = package.objects();
    for (const auto* const object : std::span(objects.types, objects.count)) {
      known_.emplace(object->type().name, object);
    }
  }
}

const MessageType& InstalledTypes::load(std::string_view name) {
  const std::lock_guard lock(mutex_);
  being_made_.clear();
  return find(name).type();
}

const ObjectType& InstalledTypes::find(std::string_view name) {
  if (const auto known = known_.find(name); known != known_.end()) {
    return *known->second;
  }
  if (!is_type_name(name)) {
    throw MessageTypeError("'" + std::string(name) + "' is no type name: package/msg/Type");
  }
  const std::string package(name.substr(0, name.find('/')));
  for (const auto& prefix : installed_prefixes()) {
    if (is_file(library_list(prefix, package))) {
      return from_library(prefix, package, name);
    }
    if (is_file(definition_list(prefix, package))) {
      return from_definition(prefix, package, name);
    }
  }
  if (const auto other = known_.lower_bound(package + "/");
      other != known_.end() && other->first.starts_with(package + "/")) {
    refuse(name, "its package has no such type");
  }
  refuse(name, "no package " + package +
                   " with messages is installed; is its prefix in AMENT_PREFIX_PATH?");
}

const ObjectType& InstalledTypes::from_library(const std::filesystem::path& prefix,
                                               const std::string& package, std::string_view name) {
  const auto list = library_list(prefix, package);
  const auto entries = read_library_list(list);
  const auto entry = std::ranges::find(entries, name, &LibraryEntry::type);
  if (entry == entries.end()) {
    refuse(name, list.string() + " does not list it");
  }
  const auto library = prefix / entry->library;
  for (const auto* const object : load_library(library, package)) {
    known_.emplace(object->type().name, object);
  }
  const auto loaded = known_.find(name);
  if (loaded == known_.end()) {
    refuse(name, library.string() + " does not hold it, though " + list.string() + " says so");
  }
  return *loaded->second;
}

const ObjectType& InstalledTypes::from_definition(const std::filesystem::path& prefix,
                                                  const std::string& package,
                                                  std::string_view name) {
  const auto list = definition_list(prefix, package);
  const auto interface_name = generator::defining_interface(name);
  if (!std::ranges::binary_search(read_definition_list(list), interface_name)) {
    refuse(name, list.string() + " does not list it");
  }
  try {
    const auto& structures = interface(prefix, interface_name).structures;
    const auto structure = std::ranges::find(structures, name, &generator::Structure::name);
    if (structure == structures.end()) {
      refuse(name, "it is no part of " + interface_name);
    }
    being_made_.emplace_back(name);
    const auto* const type = new LoadedType(
        *structure,
        [this](const generator::Field& field) -> const ObjectType& { return nested(field); });
    being_made_.pop_back();
    return *known_.emplace(type->type().name, type).first->second;
  } catch (const generator::DefinitionError& error) {
    throw MessageTypeError(error.what());
  } catch (const std::invalid_argument& error) {
    throw MessageTypeError(error.what());
  }
}

const generator::Interface& InstalledTypes::interface(const std::filesystem::path& prefix,
                                                      const std::string& interface_name) {
  if (const auto known = interfaces_.find(interface_name); known != interfaces_.end()) {
    return known->second;
  }
  return interfaces_
      .emplace(interface_name,
               generator::read_definition(interface_name, definition_file(prefix, interface_name)))
      .first->second;
}

const ObjectType& InstalledTypes::nested(const generator::Field& field) {
  const auto& used = field.type.message;
  if (const auto repeated = std::ranges::find(being_made_, used); repeated != being_made_.end()) {
    std::string cycle;
    for (auto name = repeated; name != being_made_.end(); ++name) {
      cycle += *name + " -> ";
    }
    throw generator::DefinitionError(field.location, field.name,
                                     "a type contains itself: " + cycle + used);
  }
  try {
    return find(used);
  } catch (const MessageTypeError& error) {
    const std::string_view reason = error.what();
    if (!reason.starts_with("unknown type")) {
      throw;  // says which file it is about
    }
    throw generator::DefinitionError(field.location, field.name, reason);
  }
}

std::vector<std::string> InstalledTypes::list() {
  std::vector<std::string> names;
  std::set<std::string> packages;
  // Whoever asks for a type of a package whose list is wrong is told.
  for (const auto& prefix : installed_prefixes()) {
    std::set<std::string> here;
    for_each_list(library_list(prefix, ""), [&](const std::filesystem::path& list) {
      if (packages.contains(list.filename().string())) {
        return;
      }
      here.insert(list.filename().string());
      try {
        for (auto& entry : read_library_list(list)) {
          names.push_back(std::move(entry.type));
        }
      } catch (const MessageTypeError&) {
      }
    });
    for_each_list(definition_list(prefix, ""), [&](const std::filesystem::path& list) {
      const auto package = list.filename().string();
      if (packages.contains(package) || !here.insert(package).second) {
        return;
      }
      try {
        for (const auto& interface_name : read_definition_list(list)) {
          std::ranges::move(structure_names(interface_name), std::back_inserter(names));
        }
      } catch (const MessageTypeError&) {
      }
    });
    packages.merge(here);
  }
  return names;
}

}  // namespace pipescout::idl
