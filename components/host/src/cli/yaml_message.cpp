// SPDX-License-Identifier: Apache-2.0
#include "cli/yaml_message.hpp"

#include <yaml-cpp/yaml.h>

#include <charconv>
#include <limits>
#include <optional>

#include "pipescout/idl/field_access.hpp"

namespace pipescout::host {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& message) {
  throw YamlMessageError((path.empty() ? "the message" : path) + ": " + message);
}

bool is_real(FieldKind kind) {
  return kind == FieldKind::kFloat32 || kind == FieldKind::kFloat64;
}

/// Quoted, so that it is a text whatever it looks like.
bool is_quoted(const YAML::Node& node) {
  return node.Tag() == "!";
}

/// All of the text as a number; `base`: of whole numbers.
template <class T, class... Base>
std::optional<T> parsed(std::string_view text, Base... base) {
  T value{};
  const auto* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value, base...);
  return end == last && error == std::errc{} && !text.empty() ? std::optional(value) : std::nullopt;
}

std::optional<ScalarValue> parse_whole_number(std::string_view text) {
  const bool negative = text.starts_with('-');
  auto digits = text.substr(negative || text.starts_with('+') ? 1 : 0);
  int base = 10;
  if (digits.starts_with("0x") || digits.starts_with("0X")) {
    base = 16;
    digits.remove_prefix(2);
  }
  const auto magnitude = parsed<std::uint64_t>(digits, base);
  if (!magnitude) {
    return std::nullopt;
  }
  if (!negative) {
    return ScalarValue(*magnitude);
  }
  constexpr std::uint64_t kLargest = std::uint64_t{1} << 63U;
  if (*magnitude > kLargest) {
    return std::nullopt;
  }
  return ScalarValue(static_cast<std::int64_t>(~*magnitude + 1));
}

std::optional<ScalarValue> parse_real_number(std::string_view text) {
  const bool negative = text.starts_with('-');
  const auto magnitude = text.substr(negative || text.starts_with('+') ? 1 : 0);
  std::optional<double> value;
  if (magnitude == ".inf" || magnitude == ".Inf" || magnitude == ".INF") {
    value = std::numeric_limits<double>::infinity();
  } else if (text == ".nan" || text == ".NaN" || text == ".NAN") {
    value = std::numeric_limits<double>::quiet_NaN();
  } else {
    value = parsed<double>(magnitude);
  }
  if (!value) {
    return std::nullopt;
  }
  return ScalarValue(negative ? -*value : *value);
}

std::optional<ScalarValue> parse_truth(const YAML::Node& node) {
  bool value = false;
  return YAML::convert<bool>::decode(node, value) ? std::optional<ScalarValue>(value)
                                                  : std::nullopt;
}

/// The number of the character that a byte is shown as: up to U+00FF.
std::optional<ScalarValue> parse_byte_character(const std::string& text) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (text.size() == 1 && at(0) < 0x80) {
    return ScalarValue(std::uint64_t{at(0)});
  }
  if (text.size() == 2 && (at(0) == 0xC2 || at(0) == 0xC3) && (at(1) & 0xC0U) == 0x80U) {
    return ScalarValue(std::uint64_t{(at(0) & 0x03U) << 6U | (at(1) & 0x3FU)});
  }
  return std::nullopt;
}

ScalarValue scalar(const MessageField& field, const YAML::Node& node, const std::string& path) {
  const auto& text = node.Scalar();
  std::optional<ScalarValue> value;
  if (field.kind == FieldKind::kBool) {
    value = parse_truth(node);
  } else if (is_real(field.kind)) {
    value = parse_real_number(text);
  } else if (field.kind == FieldKind::kOctet && is_quoted(node)) {
    value = parse_byte_character(text);
  } else {
    value = parse_whole_number(text);
    if (!value && field.kind == FieldKind::kOctet) {
      value = parse_byte_character(text);
    }
  }
  if (!value) {
    fail(path, "'" + text + "' is no " + std::string(to_string(field.kind)));
  }
  return *value;
}

void set_fields(const YAML::Node& node, const MessageType& type, void* message,
                const std::string& path);

void set_element(const YAML::Node& node, const MessageField& field, FieldEditor& editor,
                 std::size_t index, const std::string& path) {
  if (field.kind == FieldKind::kMessage) {
    set_fields(node, field.message(), editor.message(index), path);
    return;
  }
  if (!node.IsScalar()) {
    fail(path, "expected a " + std::string(to_string(field.kind)));
  }
  try {
    if (field.kind == FieldKind::kString || field.kind == FieldKind::kWString) {
      editor.set(index, std::string_view(node.Scalar()));
    } else {
      editor.set(index, scalar(field, node, path));
    }
  } catch (const YamlMessageError&) {
    throw;
  } catch (const std::exception& error) {
    // It begins with the name of the field; the whole path helps more.
    const std::string what = error.what();
    const auto name = std::string(field.name) + ": ";
    fail(path, what.starts_with(name) ? what.substr(name.size()) : what);
  }
}

void set_field(const YAML::Node& node, const MessageField& field, void* message,
               const std::string& path) {
  FieldEditor editor(field, message);
  if (field.shape == FieldShape::kSingle) {
    set_element(node, field, editor, 0, path);
    return;
  }
  if (!node.IsSequence()) {
    fail(path, "expected a list");
  }
  if (field.shape == FieldShape::kArray) {
    if (node.size() != field.length) {
      fail(path, "expected " + std::to_string(field.length) + " elements, not " +
                     std::to_string(node.size()));
    }
  } else {
    try {
      editor.resize(node.size());
    } catch (const std::length_error& error) {
      fail(path, error.what());
    }
  }
  std::size_t index = 0;
  for (const auto& element : node) {
    set_element(element, field, editor, index, path + "[" + std::to_string(index) + "]");
    ++index;
  }
}

void set_fields(const YAML::Node& node, const MessageType& type, void* message,
                const std::string& path) {
  if (node.IsNull()) {
    return;
  }
  if (!node.IsMap()) {
    fail(path, "expected a mapping with fields of " + std::string(type.name));
  }
  for (const auto& entry : node) {
    const auto name = entry.first.IsScalar() ? entry.first.Scalar() : std::string("?");
    const auto* const field = find_field(type, name);
    if (field == nullptr) {
      fail(path, "'" + name + "' is not a field of " + std::string(type.name));
    }
    set_field(entry.second, *field, message, path.empty() ? name : path + "." + name);
  }
}

}  // namespace

void set_from_yaml(const std::string& yaml, const MessageType& type, void* message) {
  YAML::Node node;
  try {
    node = YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw YamlMessageError("the values are not YAML: " + std::string(error.what()));
  }
  set_fields(node, type, message, "");
}

}  // namespace pipescout::host
