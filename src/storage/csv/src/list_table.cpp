// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/list_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_table.hpp"

namespace pipescout {
namespace {

constexpr double kLargest = 1e9;
constexpr std::string_view kDelimiters = ",;|\t";

std::string delimiter_word(char delimiter) {
  return delimiter == '\t' ? "tab" : std::string(1, delimiter);
}

/// A delimiter that the only name in a header has within it; none: there are more, or it has none.
std::optional<char> other_delimiter(const std::vector<std::string>& header) {
  const auto found =
      header.size() == 1 ? header.front().find_first_of(kDelimiters) : std::string::npos;
  return found == std::string::npos ? std::nullopt : std::optional(header.front()[found]);
}

struct LengthUnit {
  const char* name;
  const char* symbol;
  double metres;
};
constexpr std::array<LengthUnit, 5> kUnits{{{"metres", "m", 1.0},
                                            {"millimetres", "mm", 1e-3},
                                            {"centimetres", "cm", 1e-2},
                                            {"kilometres", "km", 1e3},
                                            {"feet", "ft", 0.3048}}};

}  // namespace

std::string folded(std::string_view text) {
  constexpr std::string_view kNoBreakSpace = "\xC2\xA0";
  std::string result;
  bool blank = false;
  while (!text.empty()) {
    const auto code = static_cast<unsigned char>(text.front());
    if (code <= 0x20U || code == 0x7FU || text.starts_with(kNoBreakSpace)) {
      blank = true;
      text.remove_prefix(code <= 0x7FU ? 1 : kNoBreakSpace.size());
      continue;
    }
    if (blank && !result.empty()) {
      result += ' ';
    }
    blank = false;
    result += text.front();
    text.remove_prefix(1);
  }
  return result;
}

std::string read_list_text(const std::string& path) {
  std::string text = read_csv_text(path);
  if (const auto zero = text.find('\0'); zero != std::string::npos) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(zero);
    throw CsvError(path, 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n')),
                   "is not text: it contains a zero byte");
  }
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
    throw CsvError(path, 0, "is empty; a header line is needed");
  }
  return text;
}

ListTable::ListTable(const std::string& path, char delimiter, std::string_view setting)
    : path_(path), rows_(read_csv_rows(read_list_text(path), delimiter)) {
  if (!rows_.closed) {
    throw CsvError(path_, rows_.rows.back().line, "a quotation mark of this row is not closed");
  }
  if (rows_.rows.empty()) {
    throw CsvError(path_, 0, "is empty; a header line is needed");
  }
  auto& header = rows_.rows.front().cells;
  if (const auto other = other_delimiter(header)) {
    throw CsvError(path_, rows_.rows.front().line,
                   "the columns seem to be separated by '" + delimiter_word(*other) +
                       "', and are read as separated by '" + delimiter_word(delimiter) + "'" +
                       (setting.empty() ? ", the only possibility"
                                        : ": set 'delimiter' in " + std::string(setting)));
  }
  std::transform(header.begin(), header.end(), header.begin(), folded);
  if (header.size() > kMaxCsvColumns) {
    throw CsvError(
        path_, rows_.rows.front().line,
        std::to_string(header.size()) + " columns; there may be " + std::to_string(kMaxCsvColumns));
  }
  if (rows_.rows.size() == 1) {
    throw CsvError(path_, 0, "has a header but no rows");
  }
  for (const auto& row : rows_.rows) {
    if (row.cells.size() != header.size()) {
      throw CsvError(path_, row.line,
                     std::to_string(row.cells.size()) + " cells in a table of " +
                         std::to_string(header.size()) + " columns");
    }
  }
}

std::optional<std::size_t> ListTable::find_column(const std::string& wanted) const {
  const std::string name = folded(wanted);
  const auto found = std::find(columns().begin(), columns().end(), name);
  if (found == columns().end()) {
    return std::nullopt;
  }
  if (std::find(found + 1, columns().end(), name) != columns().end()) {
    throw CsvError(path_, rows_.rows.front().line, "two columns are named '" + name + "'");
  }
  return static_cast<std::size_t>(found - columns().begin());
}

std::string ListTable::cell(std::size_t row, std::size_t column) const {
  return folded(rows_.rows[row + 1].cells[column]);
}

std::optional<double> ListTable::number(std::size_t row, std::size_t column) const {
  const auto text = cell(row, column);
  if (text.empty()) {
    return std::nullopt;
  }
  const auto value = parse_csv_number(text);
  if (!value || !std::isfinite(*value)) {
    refuse(row, column,
           "'" + text + "' is not a finite number" +
               (text.find(',') != std::string::npos
                    ? "; write it without thousands separators and with a decimal point"
                    : ""));
  }
  if (!(std::abs(*value) < kLargest)) {
    refuse(row, column, "'" + text + "' is out of range");
  }
  return value;
}

double ListTable::required(std::size_t row, std::size_t column) const {
  const auto value = number(row, column);
  if (!value) {
    refuse(row, column, "is missing");
  }
  return *value;
}

void ListTable::refuse(std::size_t row, std::size_t column, const std::string& what) const {
  throw CsvError(path_, line(row), "column '" + columns()[column] + "': " + what);
}

std::optional<double> metres_per_list_unit(std::string_view unit) {
  for (const LengthUnit& known : kUnits) {
    if (unit == known.name || unit == known.symbol) {
      return known.metres;
    }
  }
  return std::nullopt;
}

std::string list_unit_names() {
  std::string names;
  for (const LengthUnit& unit : kUnits) {
    names += (names.empty() ? "" : ", ") + std::string(unit.name) + " (" + unit.symbol + ")";
  }
  return names;
}

std::optional<char> list_delimiter(std::string_view word) {
  if (word == "tab") {
    return '\t';
  }
  if (word.size() == 1 && kDelimiters.find(word) != std::string_view::npos) {
    return word.front();
  }
  return std::nullopt;
}

std::string quoted_list(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) {
    text += (text.empty() ? "'" : ", '") + name + "'";
  }
  return text;
}

}  // namespace pipescout
