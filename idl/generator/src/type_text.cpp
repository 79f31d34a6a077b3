// SPDX-License-Identifier: Apache-2.0
#include "type_text.hpp"

#include <array>

#include "names.hpp"

namespace pipescout::generator {
namespace {

struct Names {
  std::string_view msg;
  std::string_view idl;
  std::string_view cpp;
};

/// In the order of Kind. rosidl's C++ has unsigned bytes for `byte` and `char`.
constexpr std::array<Names, 16> kNames{{{"bool", "boolean", "bool"},
                                        {"byte", "octet", "std::uint8_t"},
                                        {"char", "char", "std::uint8_t"},
                                        {"int8", "int8", "std::int8_t"},
                                        {"uint8", "uint8", "std::uint8_t"},
                                        {"int16", "int16", "std::int16_t"},
                                        {"uint16", "uint16", "std::uint16_t"},
                                        {"int32", "int32", "std::int32_t"},
                                        {"uint32", "uint32", "std::uint32_t"},
                                        {"int64", "int64", "std::int64_t"},
                                        {"uint64", "uint64", "std::uint64_t"},
                                        {"float32", "float", "float"},
                                        {"float64", "double", "double"},
                                        {"string", "string", "std::string"},
                                        {"wstring", "wstring", "std::u16string"},
                                        {"", "", ""}}};

const Names& names(Kind kind) noexcept {
  return kNames[static_cast<std::size_t>(kind)];
}

}  // namespace

std::string_view msg_name(Kind kind) noexcept {
  return names(kind).msg;
}

std::string_view idl_name(Kind kind) noexcept {
  return names(kind).idl;
}

std::string_view cpp_name(Kind kind) noexcept {
  return names(kind).cpp;
}

std::optional<Kind> kind_of_msg_name(std::string_view name) noexcept {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (!kNames[i].msg.empty() && kNames[i].msg == name) {
      return static_cast<Kind>(i);
    }
  }
  return std::nullopt;
}

std::string msg_type(const Type& type, std::string_view package) {
  std::string text(msg_name(type.kind));
  if (type.kind == Kind::kMessage) {
    const auto parts = split_name(type.message);
    text = parts.package == package ? parts.type : parts.package + "/" + parts.type;
  }
  if (type.text_length != 0) {
    text += "<=" + std::to_string(type.text_length);
  }
  if (type.shape == Shape::kArray) {
    text += "[" + std::to_string(type.length) + "]";
  } else if (type.shape == Shape::kSequence) {
    text += type.length != 0 ? "[<=" + std::to_string(type.length) + "]" : "[]";
  }
  return text;
}

std::string cpp_element_type(const Type& type) {
  return type.kind == Kind::kMessage ? scoped_name(type.message) : std::string(cpp_name(type.kind));
}

std::string cpp_type(const Type& type) {
  const auto element = cpp_element_type(type);
  switch (type.shape) {
    case Shape::kSingle:
      return element;
    case Shape::kArray:
      return "std::array<" + element + ", " + std::to_string(type.length) + ">";
    case Shape::kSequence:
      break;
  }
  if (type.length != 0) {
    return "pipescout::BoundedVector<" + element + ", " + std::to_string(type.length) + ">";
  }
  return "std::vector<" + element + ">";
}

}  // namespace pipescout::generator
