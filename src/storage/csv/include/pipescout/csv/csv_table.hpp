// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/csv/csv_reader.hpp"

namespace pipescout {

/// A whole table in memory, for lists of which rows are looked up: read by `CsvReader`.
class CsvTable {
 public:
  /// Accepts and refuses the same as CsvReader.
  CsvTable(std::string_view bytes, std::string_view path, const CsvFormat& format = {});

  [[nodiscard]] const std::string& path() const noexcept { return numbers_->path(); }
  [[nodiscard]] const std::vector<std::string>& columns() const noexcept {
    return numbers_->columns();
  }
  [[nodiscard]] std::size_t header_line() const noexcept { return numbers_->header_line(); }
  /// As those of CsvReader.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
  /// At least 1.
  [[nodiscard]] std::size_t rows() const noexcept { return rows_.size(); }
  /// Of the file, from 1.
  [[nodiscard]] std::size_t line(std::size_t row) const { return rows_[row].line; }
  /// Compares `folded` names. Throws CsvError for a name that two columns have.
  [[nodiscard]] std::optional<std::size_t> find_column(std::string_view name) const {
    return numbers_->find_column(name);
  }
  [[nodiscard]] const CsvNumbers& numbers() const noexcept { return *numbers_; }

  /// Not checked: the row has the cell.
  [[nodiscard]] const std::string& cell(std::size_t row, std::size_t column) const {
    return rows_[row].cells[column];
  }
  /// Cells of a row.
  [[nodiscard]] std::size_t cells(std::size_t row) const { return rows_[row].cells.size(); }
  /// A number below 1e9 in size, or nan, inf, -inf; NaN when the cell is empty. Throws CsvError.
  [[nodiscard]] double any_number(std::size_t row, std::size_t column) const;
  /// A finite one; nothing when the cell is empty. Throws CsvError.
  [[nodiscard]] std::optional<double> number(std::size_t row, std::size_t column) const;
  /// The same, and an empty cell is refused.
  [[nodiscard]] double required(std::size_t row, std::size_t column) const;

  /// Throws the CsvError "column 'x': <what>".
  [[noreturn]] void refuse(std::size_t row, std::size_t column, const std::string& what) const;

 private:
  struct Row {
    std::size_t line = 0;
    std::vector<std::string> cells;
  };

  std::shared_ptr<const CsvNumbers> numbers_;
  std::vector<std::string> notes_;
  std::vector<Row> rows_;
};

}  // namespace pipescout
