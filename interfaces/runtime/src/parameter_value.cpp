// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/parameter_value.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

namespace pipescout {
namespace {

constexpr bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

template <std::size_t N>
bool is_one_of(std::string_view text, const std::array<std::string_view, N>& words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

std::optional<bool> read_bool(std::string_view text) {
  constexpr std::array<std::string_view, 11> kTrue = {"y",    "Y",    "yes", "Yes", "YES", "true",
                                                      "True", "TRUE", "on",  "On",  "ON"};
  constexpr std::array<std::string_view, 11> kFalse = {
      "n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"};
  if (is_one_of(text, kTrue)) {
    return true;
  }
  if (is_one_of(text, kFalse)) {
    return false;
  }
  return std::nullopt;
}

bool take_sign(std::string_view& text) {
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) {
    const bool negative = text.front() == '-';
    text.remove_prefix(1);
    return negative;
  }
  return false;
}

std::optional<std::int64_t> read_integer(std::string_view text) {
  const std::string_view whole = text;
  const bool negative = take_sign(text);
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    base = 16;
    text.remove_prefix(2);
  } else if (text.size() > 1 && text.front() == '0') {
    base = 8;
    text.remove_prefix(1);
  }
  std::uint64_t magnitude = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, magnitude, base);
  if (text.empty() || stop != end || error == std::errc::invalid_argument) {
    return std::nullopt;
  }
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (error == std::errc::result_out_of_range || magnitude > kMax + (negative ? 1U : 0U)) {
    throw std::out_of_range("integer " + std::string(whole) +
                            " does not fit 64 bits; a double is written with a '.'");
  }
  return static_cast<std::int64_t>(negative ? 0 - magnitude : magnitude);
}

std::optional<double> read_double(std::string_view text) {
  constexpr std::array<std::string_view, 3> kNan = {".nan", ".NaN", ".NAN"};
  constexpr std::array<std::string_view, 3> kInf = {".inf", ".Inf", ".INF"};
  if (is_one_of(text, kNan)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const std::string_view whole = text;
  const bool negative = take_sign(text);
  if (is_one_of(text, kInf)) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    return negative ? -kInfinity : kInfinity;
  }
  if (text.empty() || text.front() == '-') {
    return std::nullopt;
  }
  double magnitude = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, magnitude);
  if (stop != end || error == std::errc::invalid_argument) {
    return std::nullopt;
  }
  if (error == std::errc::result_out_of_range) {
    throw std::out_of_range("number " + std::string(whole) + " does not fit a double");
  }
  return negative ? -magnitude : magnitude;
}

// Digits and decimal exponent of the shortest text that reads back to the same double, as Python
// lays it out: fixed notation for exponents from -4 to 15, scientific with two digits otherwise.
// `yaml`: PyYAML takes a number for a double only with a '.' in it, so 1e-07 becomes 1.0e-07.
std::string finite_text(double value, bool yaml) {
  std::array<char, 64> buffer{};
  const auto written = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                     std::chars_format::scientific);
  const std::string_view scientific(buffer.data(),
                                    static_cast<std::size_t>(written.ptr - buffer.data()));
  const std::size_t e = scientific.find('e');
  int exponent = 0;
  const std::size_t exponent_at = e + (scientific[e + 1] == '+' ? 2 : 1);
  std::from_chars(scientific.data() + exponent_at, scientific.data() + scientific.size(), exponent);
  if (exponent >= -4 && exponent < 16) {
    const auto fixed = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                     std::chars_format::fixed);
    std::string result(buffer.data(), fixed.ptr);
    if (result.find('.') == std::string::npos) {
      result += ".0";
    }
    return result;
  }
  std::string result(scientific);
  if (yaml && result.find('.') == std::string::npos) {
    result.insert(e, ".0");
  }
  return result;
}

std::string python_text(double value) {
  if (std::isnan(value)) {
    return "nan";
  }
  if (std::isinf(value)) {
    return value < 0 ? "-inf" : "inf";
  }
  return finite_text(value, false);
}

std::string yaml_text(double value) {
  if (std::isnan(value)) {
    return ".nan";
  }
  if (std::isinf(value)) {
    return value < 0 ? "-.inf" : ".inf";
  }
  return finite_text(value, true);
}

std::string hex_escape(unsigned char byte) {
  constexpr std::string_view kHex = "0123456789abcdef";
  return {'\\', 'x', kHex[byte >> 4U], kHex[byte & 0xFU]};
}

// repr() of a Python string; bytes above ASCII are text in UTF-8 and stay.
std::string python_quoted(std::string_view text) {
  const bool has_single = text.find('\'') != std::string_view::npos;
  const bool has_double = text.find('"') != std::string_view::npos;
  const char quote = has_single && !has_double ? '"' : '\'';
  std::string result(1, quote);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == quote || c == '\\') {
      result += '\\';
      result += c;
    } else if (c == '\n') {
      result += "\\n";
    } else if (c == '\r') {
      result += "\\r";
    } else if (c == '\t') {
      result += "\\t";
    } else if (byte < 0x20 || byte == 0x7f) {
      result += hex_escape(byte);
    } else {
      result += c;
    }
  }
  result += quote;
  return result;
}

// repr() of a Python bytes object of one byte, as the elements of a byte array are shown.
std::string python_byte(std::uint8_t byte) {
  if (byte == '\'') {
    return "b\"'\"";
  }
  if (byte < 0x80) {
    return "b" + python_quoted(std::string(1, static_cast<char>(byte)));
  }
  return "b'" + hex_escape(byte) + "'";
}

// Words that any YAML reader takes for a string, whichever version of YAML it follows.
bool is_plain_string(std::string_view text) {
  constexpr std::array<std::string_view, 5> kNull = {"~", "null", "Null", "NULL", ""};
  const auto is_safe = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_' ||
           c == '/' || c == '.' || c == '-';
  };
  if (is_one_of(text, kNull) || is_digit(text.front()) || text.front() == '.' ||
      text.front() == '-' || !std::all_of(text.begin(), text.end(), is_safe)) {
    return false;
  }
  return type_yaml_scalar(text).type() == ParameterType::kString;
}

std::string yaml_string(std::string_view text) {
  if (is_plain_string(text)) {
    return std::string(text);
  }
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (c == '\n') {
      result += "\\n";
    } else if (c == '\t') {
      result += "\\t";
    } else if (c == '\r') {
      result += "\\r";
    } else if (byte < 0x20 || byte == 0x7f) {
      result += hex_escape(byte);
    } else {
      result += c;
    }
  }
  result += '"';
  return result;
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string result;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = (group << 8U) | (k < count ? bytes[i + k] : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      result += k <= count ? kAlphabet[(group >> (18U - 6U * k)) & 0x3FU] : '=';
    }
  }
  return result;
}

template <class Elements, class ToText>
std::string bracketed(const Elements& elements, const ToText& to_text) {
  std::string result = "[";
  bool is_first = true;
  for (const auto& element : elements) {
    if (!is_first) {
      result += ", ";
    }
    is_first = false;
    result += to_text(element);
  }
  result += "]";
  return result;
}

// An array.array of Python: its type code and the elements, which an empty one does not show.
template <class Elements, class ToText>
std::string python_array(char type_code, const Elements& elements, const ToText& to_text) {
  std::string result = std::string("array('") + type_code + "'";
  if (!elements.empty()) {
    result += ", " + bracketed(elements, to_text);
  }
  return result + ")";
}

struct PythonText {
  std::string operator()(std::monostate) const { return "None"; }
  std::string operator()(bool value) const { return value ? "True" : "False"; }
  std::string operator()(std::int64_t value) const { return std::to_string(value); }
  std::string operator()(double value) const { return python_text(value); }
  std::string operator()(const std::string& value) const { return value; }
  std::string operator()(const std::vector<std::uint8_t>& value) const {
    return bracketed(value, python_byte);
  }
  std::string operator()(const std::vector<bool>& value) const { return bracketed(value, *this); }
  std::string operator()(const std::vector<std::int64_t>& value) const {
    return python_array('q', value, *this);
  }
  std::string operator()(const std::vector<double>& value) const {
    return python_array('d', value, *this);
  }
  std::string operator()(const std::vector<std::string>& value) const {
    return bracketed(value, python_quoted);
  }
};

struct YamlText {
  std::string operator()(std::monostate) const { return "null"; }
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return std::to_string(value); }
  std::string operator()(double value) const { return yaml_text(value); }
  std::string operator()(const std::string& value) const { return yaml_string(value); }
  std::string operator()(const std::vector<std::uint8_t>& value) const {
    return "!!binary \"" + base64(value) + "\"";
  }
  template <class T>
  std::string operator()(const std::vector<T>& value) const {
    return bracketed(value, *this);
  }
};

}  // namespace

const char* to_string(ParameterType type) noexcept {
  switch (type) {
    case ParameterType::kNotSet:
      return "not set";
    case ParameterType::kBool:
      return "boolean";
    case ParameterType::kInteger:
      return "integer";
    case ParameterType::kDouble:
      return "double";
    case ParameterType::kString:
      return "string";
    case ParameterType::kByteArray:
      return "byte array";
    case ParameterType::kBoolArray:
      return "boolean array";
    case ParameterType::kIntegerArray:
      return "integer array";
    case ParameterType::kDoubleArray:
      return "double array";
    case ParameterType::kStringArray:
      return "string array";
  }
  return "unknown type";
}

bool is_array(ParameterType type) noexcept {
  return type >= ParameterType::kByteArray && type <= ParameterType::kStringArray;
}

const char* value_label(ParameterType type) noexcept {
  switch (type) {
    case ParameterType::kNotSet:
      break;
    case ParameterType::kBool:
      return "Boolean value is:";
    case ParameterType::kInteger:
      return "Integer value is:";
    case ParameterType::kDouble:
      return "Double value is:";
    case ParameterType::kString:
      return "String value is:";
    case ParameterType::kByteArray:
      return "Byte values are:";
    case ParameterType::kBoolArray:
      return "Boolean values are:";
    case ParameterType::kIntegerArray:
      return "Integer values are:";
    case ParameterType::kDoubleArray:
      return "Double values are:";
    case ParameterType::kStringArray:
      return "String values are:";
  }
  return "Parameter not set.";
}

std::string to_string(const ParameterValue& value) {
  return value.visit(PythonText{});
}

std::string to_yaml(const ParameterValue& value) {
  return value.visit(YamlText{});
}

ParameterValue type_yaml_scalar(std::string_view text) {
  if (const auto value = read_bool(text)) {
    return *value;
  }
  if (const auto value = read_integer(text)) {
    return *value;
  }
  if (const auto value = read_double(text)) {
    return *value;
  }
  return text;
}

}  // namespace pipescout
