// SPDX-License-Identifier: Apache-2.0
#include "values.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "definition_error.hpp"
#include "type_text.hpp"

namespace pipescout::generator {
namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return lower;
}

std::optional<std::uint64_t> parse_magnitude(std::string_view digits, bool leading_zero_is_octal) {
  int base = 10;
  if (digits.size() > 1 && digits[0] == '0') {
    const char sign = digits[1];
    if (sign == 'x' || sign == 'X') {
      base = 16;
    } else if (sign == 'o' || sign == 'O') {
      base = 8;
    } else if (sign == 'b' || sign == 'B') {
      base = 2;
    }
    if (base != 10) {
      digits.remove_prefix(2);
    } else if (leading_zero_is_octal) {
      base = 8;
    }
  }
  std::uint64_t magnitude = 0;
  const auto* const last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, magnitude, base);
  if (digits.empty() || end != last || error != std::errc{}) {
    return std::nullopt;
  }
  return magnitude;
}

Value parse_integer(Kind kind, std::string_view text, bool leading_zero_is_octal,
                    const Location& location, std::string_view name) {
  const bool negative = text.starts_with('-');
  const auto digits = text.substr(negative || text.starts_with('+') ? 1 : 0);
  const auto magnitude = parse_magnitude(digits, leading_zero_is_octal);
  if (!magnitude) {
    throw DefinitionError(location, name,
                          "'" + std::string(text) + "' is not an integer of 64 bits");
  }
  const auto bits = static_cast<unsigned>(8 * size_of(kind));
  const std::uint64_t largest =
      std::numeric_limits<std::uint64_t>::max() >> (64U - bits + (is_signed(kind) ? 1U : 0U));
  const std::uint64_t limit = negative ? (is_signed(kind) ? largest + 1 : 0) : largest;
  if (*magnitude > limit) {
    throw DefinitionError(location, name,
                          std::string(text) + " does not fit into " + std::string(msg_name(kind)));
  }
  if (is_signed(kind)) {
    return static_cast<std::int64_t>(negative ? ~*magnitude + 1 : *magnitude);
  }
  return *magnitude;
}

Value parse_floating_point(Kind kind, std::string_view text, const Location& location,
                           std::string_view name) {
  const auto digits = text.substr(text.starts_with('+') ? 1 : 0);
  double value = 0.0;
  const auto* const last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, value);
  if (digits.empty() || end != last || error != std::errc{}) {
    throw DefinitionError(location, name, "'" + std::string(text) + "' is not a number");
  }
  if (kind == Kind::kFloat32 && std::isfinite(value) &&
      std::abs(value) > std::numeric_limits<float>::max()) {
    throw DefinitionError(location, name, std::string(text) + " does not fit into float32");
  }
  return value;
}

bool is_quote(char c) {
  return c == '\'' || c == '"';
}

}  // namespace

std::string_view trim(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n\f\v";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

Value parse_number(Kind kind, std::string_view text, bool leading_zero_is_octal,
                   const Location& location, std::string_view name) {
  if (kind == Kind::kBool) {
    const auto word = lower_case(text);
    if (word == "true" || word == "1") {
      return true;
    }
    if (word == "false" || word == "0") {
      return false;
    }
    throw DefinitionError(location, name, "'" + std::string(text) + "' is neither true nor false");
  }
  if (is_floating_point(kind)) {
    return parse_floating_point(kind, text, location, name);
  }
  return parse_integer(kind, text, leading_zero_is_octal, location, name);
}

std::string parse_text(std::string_view text, const Location& location, std::string_view name) {
  if (text.empty() || !is_quote(text.front())) {
    return std::string(text);
  }
  // A backslash means itself, except ahead of the quote.
  const char quote = text.front();
  std::string content;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == quote) {
      if (i + 1 != text.size()) {
        break;
      }
      return content;
    }
    if (text[i] == '\\' && i + 2 < text.size() && text[i + 1] == quote) {
      ++i;
    }
    content += text[i];
  }
  throw DefinitionError(location, name, "the quotes of " + std::string(text) + " do not match");
}

Value parse_value(Kind kind, std::string_view text, const Location& location,
                  std::string_view name) {
  if (is_text(kind)) {
    return parse_text(text, location, name);
  }
  return parse_number(kind, text, false, location, name);
}

std::vector<std::string> split_list(std::string_view text, const Location& location,
                                    std::string_view name) {
  const bool bracketed = text.size() >= 2 && ((text.front() == '[' && text.back() == ']') ||
                                              (text.front() == '(' && text.back() == ')'));
  if (!bracketed) {
    throw DefinitionError(location, name,
                          "'" + std::string(text) + "' is not a list of values in brackets");
  }
  const auto inside = text.substr(1, text.size() - 2);
  std::vector<std::string> elements;
  std::string element;
  char quote = '\0';
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const char c = inside[i];
    if (quote != '\0' && c == '\\' && i + 1 < inside.size()) {
      element += c;
      element += inside[++i];
      continue;
    }
    if (quote != '\0') {
      quote = c == quote ? '\0' : quote;
    } else if (is_quote(c)) {
      quote = c;
    } else if (c == ',') {
      elements.emplace_back(trim(element));
      element.clear();
      continue;
    }
    element += c;
  }
  // Python writes a tuple of one element with a comma behind it.
  if (const auto last = trim(element); !last.empty()) {
    elements.emplace_back(last);
  }
  return elements;
}

std::vector<Value> parse_default(const Type& type, std::string_view text, const Location& location,
                                 std::string_view name) {
  if (type.shape == Shape::kSingle) {
    return {parse_value(type.kind, text, location, name)};
  }
  std::vector<Value> values;
  for (const auto& element : split_list(text, location, name)) {
    values.push_back(parse_value(type.kind, element, location, name));
  }
  return values;
}

void check_default(const Field& field) {
  if (!field.default_value) {
    return;
  }
  const auto& type = field.type;
  if (type.kind == Kind::kMessage) {
    throw DefinitionError(field.location, field.name, "a message cannot have a default value");
  }
  const auto count = field.default_value->size();
  if (type.shape == Shape::kArray && count != type.length) {
    throw DefinitionError(field.location, field.name,
                          "the default has " + std::to_string(count) + " values for an array of " +
                              std::to_string(type.length));
  }
  if (type.shape == Shape::kSequence && type.length != 0 && count > type.length) {
    throw DefinitionError(field.location, field.name,
                          "the default has " + std::to_string(count) + " values, the bound is " +
                              std::to_string(type.length));
  }
  for (const auto& value : *field.default_value) {
    const auto* const text = std::get_if<std::string>(&value);
    if (text != nullptr && type.text_length != 0 && text->size() > type.text_length) {
      throw DefinitionError(field.location, field.name,
                            "the default is longer than the bound of " +
                                std::to_string(type.text_length) + " characters");
    }
  }
}

std::string number_text(const Value& value) {
  if (const auto* const truth = std::get_if<bool>(&value)) {
    return *truth ? "true" : "false";
  }
  std::array<char, 32> buffer{};
  auto* const last = buffer.data() + buffer.size();
  char* end = buffer.data();
  if (const auto* const number = std::get_if<double>(&value)) {
    end = std::to_chars(buffer.data(), last, *number).ptr;
    std::string text(buffer.data(), end);
    if (std::isfinite(*number) && text.find_first_of(".e") == std::string::npos) {
      text += ".0";
    }
    return text;
  }
  if (const auto* const number = std::get_if<std::int64_t>(&value)) {
    end = std::to_chars(buffer.data(), last, *number).ptr;
  } else {
    end = std::to_chars(buffer.data(), last, std::get<std::uint64_t>(value)).ptr;
  }
  return {buffer.data(), end};
}

}  // namespace pipescout::generator
