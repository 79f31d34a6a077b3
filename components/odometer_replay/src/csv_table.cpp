// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometer_replay/csv_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

namespace pipescout {

namespace {

constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::vector<std::string> split(std::string_view line) {
  std::vector<std::string> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    cells.emplace_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) {
      return cells;
    }
    line.remove_prefix(comma + 1);
  }
}

void check_characters(std::string_view line, const std::string& path, std::size_t number) {
  for (const char character : line) {
    const auto code = static_cast<unsigned char>(character);
    if (character == '"') {
      throw CsvError(path, number, "quotes are not supported");
    }
    if ((code < 0x20 && character != '\t') || code == 0x7F) {
      throw CsvError(path, number, "control character " + std::to_string(code));
    }
  }
}

void check_columns(const std::vector<std::string>& columns, std::string_view line,
                   const std::string& path, std::size_t number) {
  if (columns.size() == 1 && line.find_first_of(";\t") != std::string_view::npos) {
    throw CsvError(path, number, "columns must be separated by commas");
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].empty()) {
      throw CsvError(path, number, "column " + std::to_string(i + 1) + " has no name");
    }
    if (std::find(columns.begin(), columns.begin() + static_cast<std::ptrdiff_t>(i), columns[i]) !=
        columns.begin() + static_cast<std::ptrdiff_t>(i)) {
      throw CsvError(path, number, "two columns are named '" + columns[i] + "'");
    }
  }
}

}  // namespace

CsvError::CsvError(const std::string& path, std::size_t line, const std::string& message)
    : std::runtime_error(path + (line == 0 ? "" : ":" + std::to_string(line)) + ": " + message),
      line_(line) {}

std::optional<std::size_t> CsvTable::find_column(std::string_view name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end()) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(found - columns.begin());
}

CsvTable parse_csv(std::string_view text, std::string_view path) {
  CsvTable table;
  table.path = path;
  if (text.substr(0, 2) == "\xFF\xFE" || text.substr(0, 2) == "\xFE\xFF") {
    throw CsvError(table.path, 0, "is UTF-16; save it as UTF-8");
  }
  if (text.substr(0, kUtf8Mark.size()) == kUtf8Mark) {
    text.remove_prefix(kUtf8Mark.size());
  }

  std::size_t number = 0;
  std::size_t first_empty = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    if (!line.empty() && line.back() == '\r') {
      line.remove_suffix(1);
    }
    if (trimmed(line).empty()) {
      first_empty = first_empty == 0 ? number : first_empty;
      continue;
    }
    if (first_empty != 0) {
      throw CsvError(table.path, first_empty, "empty line");
    }
    check_characters(line, table.path, number);
    std::vector<std::string> cells = split(line);
    if (table.columns.empty()) {
      check_columns(cells, line, table.path, number);
      table.columns = std::move(cells);
    } else if (cells.size() != table.columns.size()) {
      throw CsvError(table.path, number,
                     std::to_string(cells.size()) + " cells in a table of " +
                         std::to_string(table.columns.size()) + " columns");
    } else {
      table.rows.push_back({number, std::move(cells)});
    }
  }
  if (table.columns.empty()) {
    throw CsvError(table.path, 0, "is empty; a header line is needed");
  }
  if (table.rows.empty()) {
    throw CsvError(table.path, 0, "has a header but no rows");
  }
  return table;
}

std::optional<double> parse_csv_number(std::string_view cell) {
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
  // from_chars takes more spellings of these, such as "nan(x)".
  if (lower.find_first_not_of("+-.0123456789e") != std::string::npos) {
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

}  // namespace pipescout
