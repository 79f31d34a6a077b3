// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "cpp_emitter.hpp"
#include "values.hpp"

namespace pipescout::generator {
namespace {

std::string floating_point_literal(Kind kind, double value) {
  const std::string type = kind == Kind::kFloat32 ? "float" : "double";
  if (std::isnan(value)) {
    return "std::numeric_limits<" + type + ">::quiet_NaN()";
  }
  if (std::isinf(value)) {
    return std::string(value < 0 ? "-" : "") + "std::numeric_limits<" + type + ">::infinity()";
  }
  return number_text(value) + (kind == Kind::kFloat32 ? "f" : "");
}

std::string octal_escape(unsigned char c) {
  std::string digits = "\\000";
  digits[1] = static_cast<char>('0' + (c >> 6U));
  digits[2] = static_cast<char>('0' + ((c >> 3U) & 7U));
  digits[3] = static_cast<char>('0' + (c & 7U));
  return digits;
}

}  // namespace

std::string cpp_string(std::string_view text) {
  std::string literal = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      literal += {'\\', c};
    } else if (c == '\n') {
      literal += "\\n";
    } else if (const auto byte = static_cast<unsigned char>(c); byte < 0x20 || byte == 0x7f) {
      literal += octal_escape(byte);
    } else {
      literal += c;
    }
  }
  return literal + "\"";
}

std::string cpp_literal(Kind kind, const Value& value) {
  if (const auto* const text = std::get_if<std::string>(&value)) {
    return (kind == Kind::kWString ? "u" : "") + cpp_string(*text);
  }
  if (const auto* const number = std::get_if<double>(&value)) {
    return floating_point_literal(kind, *number);
  }
  if (const auto* const number = std::get_if<std::int64_t>(&value)) {
    if (*number == std::numeric_limits<std::int64_t>::min()) {
      return "std::numeric_limits<std::int64_t>::min()";
    }
    return std::to_string(*number);
  }
  const auto text = number_text(value);
  return std::holds_alternative<std::uint64_t>(value) ? text + "U" : text;
}

}  // namespace pipescout::generator
