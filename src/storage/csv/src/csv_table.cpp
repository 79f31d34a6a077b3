// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_table.hpp"

#include <cmath>
#include <limits>

#include "pipescout/csv/csv_words.hpp"

namespace pipescout {

CsvTable::CsvTable(std::string_view bytes, std::string_view path, const CsvFormat& format) {
  CsvReader reader(bytes, path, format);
  numbers_ = reader.numbers();
  notes_ = reader.notes();
  rows_.reserve(reader.rows());
  while (reader.next()) {
    rows_.push_back({reader.line(), {reader.cells().begin(), reader.cells().end()}});
  }
}

double CsvTable::any_number(std::size_t row, std::size_t column) const {
  constexpr double kLargest = 1e9;
  const std::string& text = cell(row, column);
  if (folded(text).empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto value = numbers_->number(column, line(row), text);
  if (!value) {
    refuse(row, column, "'" + folded(text) + "' is not a finite number");
  }
  if (std::isfinite(*value) && !(std::abs(*value) < kLargest)) {
    refuse(row, column, "'" + folded(text) + "' is out of range");
  }
  return *value;
}

std::optional<double> CsvTable::number(std::size_t row, std::size_t column) const {
  const double value = any_number(row, column);
  if (std::isfinite(value)) {
    return value;
  }
  if (!folded(cell(row, column)).empty()) {
    refuse(row, column, "'" + folded(cell(row, column)) + "' is not a finite number");
  }
  return std::nullopt;
}

double CsvTable::required(std::size_t row, std::size_t column) const {
  const auto value = number(row, column);
  if (!value) {
    refuse(row, column, "is missing");
  }
  return *value;
}

void CsvTable::refuse(std::size_t row, std::size_t column, const std::string& what) const {
  throw CsvError(path(), line(row), "column '" + columns()[column] + "': " + what);
}

}  // namespace pipescout
