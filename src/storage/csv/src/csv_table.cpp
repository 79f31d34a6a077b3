// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <system_error>

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
  std::set<std::string_view> names;
  for (const std::string& column : columns) {
    if (column.empty()) {
      throw CsvError(path, number, "column " + std::to_string(names.size() + 1) + " has no name");
    }
    if (!names.insert(column).second) {
      throw CsvError(path, number, "two columns are named '" + column + "'");
    }
  }
}

std::optional<std::size_t> index_of(const std::vector<std::string>& columns,
                                    std::string_view name) {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end()) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(found - columns.begin());
}

}  // namespace

CsvError::CsvError(const std::string& path, std::size_t line, const std::string& message)
    : std::runtime_error(path + (line == 0 ? "" : ":" + std::to_string(line)) + ": " + message),
      line_(line) {}

CsvReader::CsvReader(std::string_view text, std::string_view path) : path_(path), text_(text) {
  if (text_.substr(0, 2) == "\xFF\xFE" || text_.substr(0, 2) == "\xFE\xFF") {
    throw CsvError(path_, 0, "is UTF-16; save it as UTF-8");
  }
  if (text_.substr(0, kUtf8Mark.size()) == kUtf8Mark) {
    text_.remove_prefix(kUtf8Mark.size());
  }
  // Without the empty lines at the end, every empty line is an error.
  text_ = text_.substr(0, text_.find_last_not_of(" \t\r\n") + 1);
  if (text_.empty()) {
    throw CsvError(path_, 0, "is empty; a header line is needed");
  }
  const std::string_view line = take_line();
  split(line);
  if (cells_of_line_ > kMaxCsvColumns) {
    throw CsvError(path_, line_,
                   std::to_string(cells_of_line_) + " columns; there may be " +
                       std::to_string(kMaxCsvColumns));
  }
  columns_.assign(cells_.begin(), cells_.end());
  check_columns(columns_, line, path_, line_);
}

std::optional<std::size_t> CsvReader::find_column(std::string_view name) const {
  return index_of(columns_, name);
}

std::size_t CsvReader::maximum_rows_left() const noexcept {
  if (text_.empty()) {
    return 0;
  }
  const auto lines = 1 + static_cast<std::size_t>(std::count(text_.begin(), text_.end(), '\n'));
  // A row has a comma or a line end for each column: short lines are no rows.
  return std::min(lines, (text_.size() + 1) / columns_.size());
}

bool CsvReader::next() {
  if (text_.empty()) {
    if (!has_rows_) {
      throw CsvError(path_, 0, "has a header but no rows");
    }
    return false;
  }
  split(take_line());
  if (cells_of_line_ != columns_.size()) {
    throw CsvError(path_, line_,
                   std::to_string(cells_of_line_) + " cells in a table of " +
                       std::to_string(columns_.size()) + " columns");
  }
  has_rows_ = true;
  return true;
}

void CsvReader::refuse(std::size_t column, const std::string& expected) const {
  throw CsvError(path_, line_,
                 "column '" + columns_[column] + "': '" + std::string(cells_[column]) +
                     "' is not " + expected);
}

std::string_view CsvReader::take_line() {
  const std::size_t end = text_.find('\n');
  std::string_view line = text_.substr(0, end);
  text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
  ++line_;
  if (!line.empty() && line.back() == '\r') {
    line.remove_suffix(1);
  }
  if (trimmed(line).empty()) {
    throw CsvError(path_, line_, "empty line");
  }
  check_characters(line, path_, line_);
  return line;
}

void CsvReader::split(std::string_view line) {
  cells_.clear();
  cells_of_line_ = 0;
  while (true) {
    const std::size_t comma = line.find(',');
    ++cells_of_line_;
    // A line of millions of commas takes no memory.
    if (cells_.size() < kMaxCsvColumns) {
      cells_.push_back(trimmed(line.substr(0, comma)));
    }
    if (comma == std::string_view::npos) {
      return;
    }
    line.remove_prefix(comma + 1);
  }
}

std::optional<std::size_t> CsvTable::find_column(std::string_view name) const {
  return index_of(columns, name);
}

CsvTable parse_csv(std::string_view text, std::string_view path) {
  CsvReader reader(text, path);
  CsvTable table{.path = reader.path(), .columns = reader.columns(), .rows = {}};
  while (reader.next()) {
    table.rows.push_back({reader.line(), {reader.cells().begin(), reader.cells().end()}});
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
