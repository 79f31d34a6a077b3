// SPDX-License-Identifier: Apache-2.0
#include "number_text.hpp"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace pipescout {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\n");
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(" \t\n") - first + 1);
}

std::optional<double> number(std::string_view text) {
  // Python's own words.
  if (text == "nan" || text == "inf" || text == "-inf") {
    return number(text == "-inf" ? "-.inf" : "." + std::string(text));
  }
  try {
    const ParameterValue value = type_yaml_scalar(text);
    if (const auto* const real = value.get_if<double>()) {
      return *real;
    }
    if (const auto* const integer = value.get_if<std::int64_t>()) {
      return static_cast<double>(*integer);
    }
  } catch (const std::out_of_range&) {
    // No double has that value.
  }
  return std::nullopt;
}

std::optional<ParameterValue> numbers(const std::vector<std::string>& texts) {
  std::vector<double> values;
  for (const auto& text : texts) {
    const auto value = number(trimmed(text));
    if (!value) {
      return std::nullopt;
    }
    values.push_back(*value);
  }
  return ParameterValue(std::move(values));
}

/// The elements of "[a, b]", or nothing.
std::optional<std::vector<std::string>> elements(std::string_view text) {
  text = trimmed(text);
  if (text.size() < 2 || text.front() != '[' || text.back() != ']') {
    return std::nullopt;
  }
  text = text.substr(1, text.size() - 2);
  std::vector<std::string> result;
  for (std::size_t begin = 0; begin <= text.size();) {
    const auto comma = std::min(text.find(',', begin), text.size());
    result.emplace_back(text.substr(begin, comma - begin));
    begin = comma + 1;
  }
  return result;
}

}  // namespace

std::optional<ParameterValue> numbers_from_text(const ParameterValue& value, ParameterType type) {
  if (type == ParameterType::kDouble) {
    const auto* const text = value.get_if<std::string>();
    const auto result = text != nullptr ? number(trimmed(*text)) : std::nullopt;
    return result ? std::optional<ParameterValue>(*result) : std::nullopt;
  }
  if (type != ParameterType::kDoubleArray) {
    return std::nullopt;
  }
  if (const auto* const texts = value.get_if<std::vector<std::string>>();
      texts && !texts->empty()) {
    return numbers(*texts);
  }
  if (const auto* const text = value.get_if<std::string>()) {
    const auto list = elements(*text);
    return list ? numbers(*list) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace pipescout
