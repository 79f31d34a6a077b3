// SPDX-License-Identifier: Apache-2.0
#include "names.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "definition_error.hpp"

namespace pipescout::generator {
namespace {

bool is_lower(char c) {
  return c >= 'a' && c <= 'z';
}

bool is_upper(char c) {
  return c >= 'A' && c <= 'Z';
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

std::string replace_all(std::string_view text, char from, std::string_view to) {
  std::string result;
  for (const char c : text) {
    if (c == from) {
      result += to;
    } else {
      result += c;
    }
  }
  return result;
}

template <std::size_t N>
bool contains(const std::array<std::string_view, N>& sorted, std::string_view word) {
  return std::ranges::binary_search(sorted, word);
}

constexpr auto kCppKeywords =
    std::to_array<std::string_view>({"alignas",       "alignof",     "and",
                                     "and_eq",        "asm",         "auto",
                                     "bitand",        "bitor",       "bool",
                                     "break",         "case",        "catch",
                                     "char",          "char16_t",    "char32_t",
                                     "char8_t",       "class",       "co_await",
                                     "co_return",     "co_yield",    "compl",
                                     "concept",       "const",       "const_cast",
                                     "consteval",     "constexpr",   "constinit",
                                     "continue",      "decltype",    "default",
                                     "delete",        "do",          "double",
                                     "dynamic_cast",  "else",        "enum",
                                     "explicit",      "export",      "extern",
                                     "false",         "float",       "for",
                                     "friend",        "goto",        "if",
                                     "inline",        "int",         "long",
                                     "mutable",       "namespace",   "new",
                                     "noexcept",      "not",         "not_eq",
                                     "nullptr",       "operator",    "or",
                                     "or_eq",         "private",     "protected",
                                     "public",        "register",    "reinterpret_cast",
                                     "requires",      "return",      "short",
                                     "signed",        "sizeof",      "static",
                                     "static_assert", "static_cast", "struct",
                                     "switch",        "template",    "this",
                                     "thread_local",  "throw",       "true",
                                     "try",           "typedef",     "typeid",
                                     "typename",      "union",       "unsigned",
                                     "using",         "virtual",     "void",
                                     "volatile",      "wchar_t",     "while",
                                     "xor",           "xor_eq"});
static_assert(std::ranges::is_sorted(kCppKeywords));

/// In lower case; IDL does not distinguish.
constexpr auto kIdlKeywords = std::to_array<std::string_view>(
    {"abstract",  "any",        "attribute",   "bitfield",  "bitmask", "bitset",     "boolean",
     "case",      "char",       "component",   "connector", "const",   "consumes",   "context",
     "custom",    "default",    "double",      "emits",     "enum",    "eventtype",  "exception",
     "factory",   "false",      "finder",      "fixed",     "float",   "getraises",  "home",
     "import",    "in",         "inout",       "int16",     "int32",   "int64",      "int8",
     "interface", "local",      "long",        "manages",   "map",     "mirrorport", "module",
     "multiple",  "native",     "object",      "octet",     "oneway",  "out",        "port",
     "porttype",  "primarykey", "private",     "provides",  "public",  "publishes",  "raises",
     "readonly",  "sequence",   "setraises",   "short",     "string",  "struct",     "supports",
     "switch",    "true",       "truncatable", "typedef",   "typeid",  "typename",   "typeprefix",
     "uint16",    "uint32",     "uint64",      "uint8",     "union",   "unsigned",   "uses",
     "valuebase", "valuetype",  "void",        "wchar",     "wstring"});
static_assert(std::ranges::is_sorted(kIdlKeywords));

bool ends_with_any(std::string& name, std::initializer_list<std::string_view> suffixes) {
  for (const auto suffix : suffixes) {
    if (name.size() > suffix.size() && name.ends_with(suffix)) {
      name.resize(name.size() - suffix.size());
      return true;
    }
  }
  return false;
}

/// Letters of one case, digits and single underscores, with a letter first and none last.
template <class IsLetter>
bool is_plain(std::string_view name, IsLetter is_letter) {
  if (name.empty() || !is_letter(name.front()) || name.back() == '_' ||
      name.find("__") != std::string_view::npos) {
    return false;
  }
  return std::ranges::all_of(name, [&](char c) { return is_letter(c) || is_digit(c) || c == '_'; });
}

}  // namespace

std::string snake_case(std::string_view camel) {
  std::string snake;
  for (std::size_t i = 0; i < camel.size(); ++i) {
    const char c = camel[i];
    if (i > 0 && is_upper(c)) {
      const char before = camel[i - 1];
      const bool begins_word = i + 1 < camel.size() && is_lower(camel[i + 1]) && before != '_';
      if (is_lower(before) || is_digit(before) || begins_word) {
        snake += '_';
      }
    }
    snake += is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return snake;
}

std::string scoped_name(std::string_view ros_name) {
  return replace_all(ros_name, '/', "::");
}

std::string dds_name(std::string_view ros_name) {
  const auto parts = split_name(ros_name);
  return parts.package + "::" + parts.folder + "::dds_::" + parts.type + "_";
}

NameParts split_name(std::string_view ros_name) {
  const auto first = ros_name.find('/');
  const auto last = ros_name.rfind('/');
  return {std::string(ros_name.substr(0, first)),
          std::string(ros_name.substr(first + 1, last - first - 1)),
          std::string(ros_name.substr(last + 1))};
}

std::string defining_interface(std::string_view ros_name) {
  const auto parts = split_name(ros_name);
  std::string type = parts.type;
  if (parts.folder == "srv") {
    ends_with_any(type, {"_Request", "_Response"});
  } else if (parts.folder == "action") {
    if (ends_with_any(type, {"_Request", "_Response"})) {
      ends_with_any(type, {"_SendGoal", "_GetResult"});
    } else {
      ends_with_any(type, {"_Goal", "_Result", "_FeedbackMessage", "_Feedback"});
    }
  }
  return parts.package + "/" + parts.folder + "/" + type;
}

std::string_view folder_of(InterfaceKind kind) noexcept {
  switch (kind) {
    case InterfaceKind::kMessage:
      return "msg";
    case InterfaceKind::kService:
      return "srv";
    case InterfaceKind::kAction:
      return "action";
  }
  return "";
}

bool is_cpp_keyword(std::string_view word) noexcept {
  return contains(kCppKeywords, word);
}

bool is_idl_keyword(std::string_view word) noexcept {
  std::string lower(word);
  std::ranges::transform(lower, lower.begin(),
                         [](char c) { return is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c; });
  return contains(kIdlKeywords, lower);
}

void check_package_name(std::string_view name, const Location& location) {
  if (!is_plain(name, is_lower)) {
    throw DefinitionError(location, name,
                          "a package name has lower case letters, digits and single underscores, "
                          "begins with a letter and does not end with an underscore");
  }
}

void check_type_name(std::string_view name, const Location& location) {
  const bool plain =
      !name.empty() && is_upper(name.front()) &&
      std::ranges::all_of(name, [](char c) { return is_lower(c) || is_upper(c) || is_digit(c); });
  if (!plain) {
    throw DefinitionError(location, name,
                          "a type name has letters and digits and begins with a capital letter");
  }
}

void check_field_name(std::string_view name, const Location& location) {
  if (!is_plain(name, is_lower)) {
    throw DefinitionError(location, name,
                          "a field name has lower case letters, digits and single underscores, "
                          "begins with a letter and does not end with an underscore");
  }
  if (is_cpp_keyword(name)) {
    throw DefinitionError(location, name, "is a keyword of C++, which no field can be named");
  }
}

void check_constant_name(std::string_view name, const Location& location) {
  if (!is_plain(name, is_upper)) {
    throw DefinitionError(location, name,
                          "a constant name has capital letters, digits and single underscores, "
                          "begins with a letter and does not end with an underscore");
  }
}

}  // namespace pipescout::generator
