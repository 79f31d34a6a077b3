// SPDX-License-Identifier: Apache-2.0
#include "definitions.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "definition_error.hpp"
#include "interface_parts.hpp"
#include "names.hpp"
#include "parsers.hpp"

namespace pipescout::generator {
namespace {

InterfaceKind kind_of_folder(std::string_view folder) {
  return folder == "srv"      ? InterfaceKind::kService
         : folder == "action" ? InterfaceKind::kAction
                              : InterfaceKind::kMessage;
}

}  // namespace

Definitions::Definitions(std::vector<std::filesystem::path> roots,
                         std::map<std::string, std::filesystem::path> packages)
    : roots_(std::move(roots)), packages_(std::move(packages)) {}

std::optional<std::filesystem::path> Definitions::find_file(std::string_view interface_name) const {
  const auto parts = split_name(interface_name);
  const auto in =
      [&](const std::filesystem::path& package) -> std::optional<std::filesystem::path> {
    for (const auto& extension : {std::string(".idl"), "." + parts.folder}) {
      auto file = package / parts.folder / (parts.type + extension);
      if (std::filesystem::is_regular_file(file)) {
        return file;
      }
    }
    return std::nullopt;
  };
  if (const auto own = packages_.find(parts.package); own != packages_.end()) {
    return in(own->second);
  }
  for (const auto& root : roots_) {
    if (auto file = in(root / parts.package)) {
      return file;
    }
  }
  return std::nullopt;
}

Interface read_definition(std::string_view interface_name, const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream.is_open() || stream.bad()) {
    throw std::invalid_argument(file.string() + ": cannot be read");
  }
  const auto parts = split_name(interface_name);
  const DefinitionPath path{parts.package, kind_of_folder(parts.folder), parts.type, file.string()};
  auto interface = file.extension() == ".idl" ? parse_idl(text, path) : parse_msg(text, path);
  if (interface.kind == InterfaceKind::kAction) {
    add_action_structures(interface);
  }
  return interface;
}

const Interface& Definitions::parse(std::string_view interface_name,
                                    const std::filesystem::path& file) {
  const auto& stored =
      interfaces_.emplace(std::string(interface_name), read_definition(interface_name, file))
          .first->second;
  for (const auto& structure : stored.structures) {
    structures_.emplace(structure.name, &structure);
  }
  return stored;
}

const Interface& Definitions::load(std::string_view interface_name) {
  auto found = interfaces_.find(interface_name);
  if (found == interfaces_.end()) {
    const auto file = find_file(interface_name);
    if (!file) {
      throw std::invalid_argument("there is no definition of " + std::string(interface_name));
    }
    parse(interface_name, *file);
    found = interfaces_.find(interface_name);
  }
  for (const auto& structure : found->second.structures) {
    std::vector<std::string> within;
    link(structure, within);
  }
  return found->second;
}

/// Reads the files of all types that the structure uses; `within` are those that lead to it.
void Definitions::link(const Structure& structure, std::vector<std::string>& within) {
  if (linked_.contains(structure.name)) {
    return;
  }
  within.push_back(structure.name);
  for (const auto& field : structure.fields) {
    if (field.type.kind != Kind::kMessage) {
      continue;
    }
    const auto& used = field.type.message;
    if (const auto repeated = std::ranges::find(within, used); repeated != within.end()) {
      std::string cycle;
      for (auto name = repeated; name != within.end(); ++name) {
        cycle += *name + " -> ";
      }
      throw DefinitionError(field.location, field.name, "a type contains itself: " + cycle + used);
    }
    const auto interface_name = defining_interface(used);
    if (!interfaces_.contains(interface_name)) {
      const auto file = find_file(interface_name);
      if (!file) {
        throw DefinitionError(field.location, field.name, "unknown type " + used);
      }
      parse(interface_name, *file);
    }
    const auto target = structures_.find(used);
    if (target == structures_.end()) {
      throw DefinitionError(field.location, field.name, "unknown type " + used);
    }
    link(*target->second, within);
  }
  within.pop_back();
  linked_.insert(structure.name);
}

const Structure& Definitions::structure(std::string_view name) const {
  const auto found = structures_.find(name);
  if (found == structures_.end()) {
    throw std::invalid_argument("there is no structure " + std::string(name));
  }
  return *found->second;
}

std::optional<UniformLayout> Definitions::uniform_layout(const Field& field) const {
  const auto& type = field.type;
  // A bool in memory must be 0 or 1, whatever arrives: it is read one by one.
  if (type.shape == Shape::kSequence || type.kind == Kind::kBool || is_text(type.kind)) {
    return std::nullopt;
  }
  const std::size_t elements = type.shape == Shape::kArray ? type.length : 1;
  if (type.kind != Kind::kMessage) {
    return UniformLayout{size_of(type.kind), elements};
  }
  auto layout = uniform_layout(structure(type.message));
  if (layout) {
    layout->count *= elements;
  }
  return layout;
}

std::optional<UniformLayout> Definitions::uniform_layout(const Structure& structure) const {
  UniformLayout layout;
  for (const auto& field : structure.fields) {
    const auto part = uniform_layout(field);
    if (!part || (layout.count != 0 && part->number_size != layout.number_size)) {
      return std::nullopt;
    }
    layout = {part->number_size, layout.count + part->count};
  }
  return layout;
}

}  // namespace pipescout::generator
