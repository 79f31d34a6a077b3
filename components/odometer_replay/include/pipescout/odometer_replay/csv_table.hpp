// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// The CSV that missions are read from and written to: comma, one header line, no quotes. Text in,
/// values out: no file is touched. All functions are pure and thread-safe.
namespace pipescout {

/// A CSV text is malformed, or does not say what it must. what() is "file:line: message".
class CsvError : public std::runtime_error {
 public:
  /// `line` counts from 1; 0: the error concerns the file as a whole.
  CsvError(const std::string& path, std::size_t line, const std::string& message);

  [[nodiscard]] std::size_t line() const noexcept { return line_; }

 private:
  std::size_t line_;
};

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

/// Reads a whole text. A UTF-8 byte order mark and CR LF line ends, as spreadsheets write them, are
/// accepted, blanks around cells are dropped, and empty lines at the end are ignored. `path` names
/// the text in messages.
/// Throws CsvError for everything else that is no table: no header, no rows, a row with more or
/// fewer cells than the header, empty lines between rows, empty or repeated column names, quotes,
/// control characters, UTF-16.
[[nodiscard]] CsvTable parse_csv(std::string_view text, std::string_view path);

/// The number that a whole cell spells: decimal, '.' as decimal point, exponent allowed, or nan,
/// inf, -inf in any case. Nothing for all other text and for numbers outside double.
[[nodiscard]] std::optional<double> parse_csv_number(std::string_view cell);

/// With as many digits as it takes to read the same value back: "5.45", "1e-07", "nan", "-inf".
[[nodiscard]] std::string format_csv_number(double value);

}  // namespace pipescout
