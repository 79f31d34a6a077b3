// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// CSV files of missions: comma, one header line, no quotes. Functions work on text, not on files;
/// all are pure and thread-safe.
namespace pipescout {

/// Largest number of columns of a table.
inline constexpr std::size_t kMaxCsvColumns = 1024;

/// A CSV text is malformed or lacks required content. what() is "file:line: message".
class CsvError : public std::runtime_error {
 public:
  /// `line` counts from 1; 0: the error concerns the file as a whole.
  CsvError(const std::string& path, std::size_t line, const std::string& message);

  [[nodiscard]] std::size_t line() const noexcept { return line_; }

 private:
  std::size_t line_;
};

/// Reads a text row by row, without a copy of it. A UTF-8 byte order mark and CR LF line ends, as
/// spreadsheets write them, are accepted, blanks around cells are dropped, and empty lines at the
/// end are ignored.
///
///     for (CsvReader reader(text, path); reader.next();) { use(reader.cells()); }
class CsvReader {
 public:
  /// Reads the header. `text` must outlive the reader; `path` names it in messages. Throws CsvError
  /// for UTF-16, no header, and a header with empty or repeated names or too many of them.
  CsvReader(std::string_view text, std::string_view path);

  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  /// Unique, not empty.
  [[nodiscard]] const std::vector<std::string>& columns() const noexcept { return columns_; }
  [[nodiscard]] std::optional<std::size_t> find_column(std::string_view name) const;
  /// Upper bound of the number of remaining rows.
  [[nodiscard]] std::size_t maximum_rows_left() const noexcept;

  /// Advances to the next row, initially to the first one. False after the last. Throws CsvError
  /// for no rows at all, a row with more or fewer cells than the header, an empty line between
  /// rows, quotes, and control characters.
  [[nodiscard]] bool next();
  /// Of the current row: its line in the file, from 1.
  [[nodiscard]] std::size_t line() const noexcept { return line_; }
  /// Of the current row: parts of the text, one per column.
  [[nodiscard]] const std::vector<std::string_view>& cells() const noexcept { return cells_; }
  /// Throws the CsvError "column 'x': 'cell' is not <expected>" for a cell of the current row.
  [[noreturn]] void refuse(std::size_t column, const std::string& expected) const;

 private:
  [[nodiscard]] std::string_view take_line();
  void split(std::string_view line);

  std::string path_;
  std::string_view text_;  // what is still to be read
  std::size_t line_ = 0;
  std::vector<std::string> columns_;
  std::vector<std::string_view> cells_;
  std::size_t cells_of_line_ = 0;  // including those beyond the capacity of `cells_`
  bool has_rows_ = false;
};

/// A whole text in memory, for small ones.
struct CsvTable {
  struct Row {
    std::size_t line = 0;            ///< of the file, from 1
    std::vector<std::string> cells;  ///< one per column
  };

  std::string path;                  ///< for messages
  std::vector<std::string> columns;  ///< unique, not empty
  std::vector<Row> rows;             ///< at least one

  [[nodiscard]] std::optional<std::size_t> find_column(std::string_view name) const;
};

/// Accepts and refuses the same as CsvReader.
[[nodiscard]] CsvTable parse_csv(std::string_view text, std::string_view path);

/// The number in a cell, which must contain nothing else: decimal, '.' as decimal point, exponent
/// allowed, or nan, inf, -inf in any case. Nothing for all other text and for numbers outside
/// double.
[[nodiscard]] std::optional<double> parse_csv_number(std::string_view cell);

/// With as many digits as a lossless round trip needs: "5.45", "1e-07", "nan", "-inf".
[[nodiscard]] std::string format_csv_number(double value);

}  // namespace pipescout
