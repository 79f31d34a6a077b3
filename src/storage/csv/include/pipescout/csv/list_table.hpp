// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/csv/csv_rows.hpp"

/// Lists of vendors and of users: CSV with quotes, any delimiter and names of columns of their own.
namespace pipescout {

/// With one blank for each run of white space, line ends and control characters, and none at the
/// ends: spreadsheets break lines in headers and fill up with blanks that do not break (U+00A0).
[[nodiscard]] std::string folded(std::string_view text);

/// The text of a CSV file. Throws CsvError for what `read_csv_text` refuses, and for bytes that no
/// text has.
[[nodiscard]] std::string read_list_text(const std::string& path);

/// A table with quotes, of which only the columns that are asked for matter. Throws CsvError.
class ListTable {
 public:
  /// `setting`: where a user sets `delimiter`, for the message about a header that has another one;
  /// empty: nowhere.
  ListTable(const std::string& path, char delimiter, std::string_view setting);

  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] std::size_t rows() const noexcept { return rows_.rows.size() - 1; }
  [[nodiscard]] std::size_t line(std::size_t row) const { return rows_.rows[row + 1].line; }
  [[nodiscard]] const std::vector<std::string>& columns() const { return rows_.rows[0].cells; }

  /// Compares `folded` names. Refuses one that two columns have.
  [[nodiscard]] std::optional<std::size_t> find_column(const std::string& wanted) const;

  /// The cell `folded`.
  [[nodiscard]] std::string cell(std::size_t row, std::size_t column) const;

  /// A finite number below 1e9; nothing when the cell is empty.
  [[nodiscard]] std::optional<double> number(std::size_t row, std::size_t column) const;
  /// The same, and an empty cell is refused.
  [[nodiscard]] double required(std::size_t row, std::size_t column) const;

  [[noreturn]] void refuse(std::size_t row, std::size_t column, const std::string& what) const;

 private:
  std::string path_;
  CsvRows rows_;
};

/// Metres in a unit of length that lists have: "metres" or "m", "millimetres" (mm), "centimetres"
/// (cm), "kilometres" (km), "feet" (ft). Nothing for other names.
[[nodiscard]] std::optional<double> metres_per_list_unit(std::string_view unit);
/// "metres (m), millimetres (mm), ...", for messages.
[[nodiscard]] std::string list_unit_names();

/// The delimiter that a word means: ",", ";", "|", a tab or "tab". Nothing for other words.
[[nodiscard]] std::optional<char> list_delimiter(std::string_view word);

/// "'a', 'b', 'c'".
[[nodiscard]] std::string quoted_list(const std::vector<std::string>& names);

}  // namespace pipescout
