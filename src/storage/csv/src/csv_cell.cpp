// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_cell.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

namespace pipescout {

std::optional<double> parse_csv_number(std::string_view cell) {
  // from_chars takes more spellings of these, such as "nan(x)".
  if (cell.find_first_not_of("+-.0123456789eE") != std::string_view::npos) {
    std::string lower(cell);
    std::transform(lower.begin(), lower.end(), lower.begin(), [](char character) {
      return character >= 'A' && character <= 'Z' ? static_cast<char>(character - 'A' + 'a')
                                                  : character;
    });
    if (lower == "nan") {
      return std::numeric_limits<double>::quiet_NaN();
    }
    if (lower == "inf" || lower == "-inf") {
      const double infinity = std::numeric_limits<double>::infinity();
      return lower.front() == '-' ? -infinity : infinity;
    }
    return std::nullopt;
  }
  double value = 0.0;
  const char* const end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  if (error != std::errc{} || stop != end) {
    return std::nullopt;
  }
  return value;
}

std::string format_csv_number(double value) {
  if (std::isnan(value)) {
    return "nan";
  }
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string format_optional_csv_number(double value) {
  return std::isnan(value) ? std::string() : format_csv_number(value);
}

std::string csv_cell(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  if (text.find_first_of(",\"\r\n") == std::string_view::npos &&
      (text.empty() || (!is_blank(text.front()) && !is_blank(text.back())))) {
    return std::string(text);
  }
  std::string cell = "\"";
  for (const char c : text) {
    cell.append(c == '"' ? 2 : 1, c);
  }
  return cell + '"';
}

}  // namespace pipescout
