// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <string>
#include <variant>
#include <vector>

namespace pipescout::command_line {

/// A table for output: texts left-aligned, numbers right-aligned with the same number of decimals
/// per column.
class TextTable {
 public:
  /// monostate: no value, shown as "-".
  using Cell = std::variant<std::monostate, bool, double, std::int64_t, std::string>;

  explicit TextTable(std::vector<std::string> columns);
  /// Throws std::invalid_argument unless there is a cell for each column.
  void add_row(std::vector<Cell> cells);
  /// Columns are padded by what their characters take on a terminal; each line begins with
  /// `indent`.
  void print(std::ostream& out, const std::string& indent = "") const;

 private:
  std::vector<std::string> columns_;
  std::vector<std::vector<Cell>> rows_;
};

}  // namespace pipescout::command_line
