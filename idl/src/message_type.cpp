// SPDX-License-Identifier: Apache-2.0
#include "pipescout/idl/message_type.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <vector>

#include "built_in_packages.hpp"
#include "installed_types.hpp"

namespace pipescout {

std::string_view to_string(FieldKind kind) noexcept {
  constexpr std::array<std::string_view, 16> kNames{
      "boolean", "octet", "char",   "int8",  "uint8",  "int16",  "uint16",  "int32",
      "uint32",  "int64", "uint64", "float", "double", "string", "wstring", "message"};
  const auto index = static_cast<std::size_t>(kind);
  return index < kNames.size() ? kNames[index] : "unknown";
}

std::size_t size_of(FieldKind kind) noexcept {
  switch (kind) {
    case FieldKind::kBool:
    case FieldKind::kOctet:
    case FieldKind::kChar:
    case FieldKind::kInt8:
    case FieldKind::kUInt8:
      return 1;
    case FieldKind::kInt16:
    case FieldKind::kUInt16:
      return 2;
    case FieldKind::kInt32:
    case FieldKind::kUInt32:
    case FieldKind::kFloat32:
      return 4;
    case FieldKind::kInt64:
    case FieldKind::kUInt64:
    case FieldKind::kFloat64:
      return 8;
    case FieldKind::kString:
    case FieldKind::kWString:
    case FieldKind::kMessage:
      return 0;
  }
  return 0;
}

namespace {

const MessageType* find_built_in(std::string_view name) noexcept {
  const auto types = message_types();
  const auto found = std::ranges::lower_bound(types, name, {}, &MessageType::name);
  return found != types.end() && (*found)->name == name ? *found : nullptr;
}

}  // namespace

std::span<const MessageType* const> message_types() noexcept {
  static const auto types = [] {
    std::vector<const MessageType*> all;
    for (const auto& package : idl::built_in_packages()) {
      const auto own = package.types();
      all.insert(all.end(), own.types, own.types + own.count);
    }
    std::ranges::sort(all, {}, &MessageType::name);
    return all;
  }();
  return types;
}

const MessageType* find_message_type(std::string_view name) noexcept {
  if (const auto* const type = find_built_in(name)) {
    return type;
  }
  try {
    return &load_message_type(name);
  } catch (const std::exception&) {
    return nullptr;
  }
}

const MessageType& load_message_type(std::string_view name) {
  if (const auto* const type = find_built_in(name)) {
    return *type;
  }
  return idl::InstalledTypes::instance().load(name);
}

std::vector<std::string> known_message_types() {
  auto names = idl::InstalledTypes::list();
  for (const auto* const type : message_types()) {
    names.emplace_back(type->name);
  }
  std::ranges::sort(names);
  names.erase(std::ranges::unique(names).begin(), names.end());
  return names;
}

}  // namespace pipescout
