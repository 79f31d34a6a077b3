// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/csv/csv_format.hpp"
#include "pipescout/csv/csv_numbers.hpp"

/// The one reader of tables: those that Pipescout writes, and those that people have. Functions
/// work on bytes, not on files (csv_file.hpp).
namespace pipescout {

/// Largest number of columns of a table.
inline constexpr std::size_t kMaxCsvColumns = 1024;

/// A table is malformed or lacks required content. what() is "file:line: message".
class CsvError : public std::runtime_error {
 public:
  /// `line` counts from 1; 0: the error concerns the file as a whole.
  CsvError(const std::string& path, std::size_t line, const std::string& message);

  [[nodiscard]] std::size_t line() const noexcept { return line_; }
  /// Without file and line.
  [[nodiscard]] const std::string& message() const noexcept { return message_; }

 private:
  std::size_t line_;
  std::string message_;
};

class RowScanner;

/// Reads a table row by row, without a copy of it where it is UTF-8. Recognised, unless the format
/// says otherwise: the encoding (UTF-8, UTF-16 with a byte order mark, Windows-1252), a first line
/// "sep=;", the delimiter, quotes, the decimal mark, a row of units below the header, and the unit
/// of times; line ends may be of any system. Blanks around cells are dropped, and so are empty
/// lines, unless the table has one column, and rows of empty cells at the end. What was guessed is
/// in `notes`; where two readings are possible, CsvError names the setting that decides.
///
///     for (CsvReader reader(bytes, path); reader.next();) { use(reader.cells()); }
class CsvReader {
 public:
  /// Looks through the whole table. `bytes` must outlive the reader; `path` names it in messages.
  /// Throws CsvError for bytes that are no text, no header or no rows, too many columns, rows with
  /// more or fewer cells than the header, a quote that is not closed, and what is in doubt.
  CsvReader(std::string_view bytes, std::string_view path, const CsvFormat& format = {});
  ~CsvReader();
  CsvReader(const CsvReader&) = delete;
  CsvReader& operator=(const CsvReader&) = delete;

  [[nodiscard]] const std::string& path() const noexcept { return numbers_->path(); }
  /// Names, `folded`; some may be empty or equal.
  [[nodiscard]] const std::vector<std::string>& columns() const noexcept {
    return numbers_->columns();
  }
  [[nodiscard]] std::size_t header_line() const noexcept { return numbers_->header_line(); }
  [[nodiscard]] std::size_t rows() const noexcept { return rows_; }
  /// How the table was read, where that was a guess: sentences that name the file.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
  [[nodiscard]] const std::shared_ptr<const CsvNumbers>& numbers() const noexcept {
    return numbers_;
  }
  /// Compares `folded` names. Throws CsvError for a name that two columns have.
  [[nodiscard]] std::optional<std::size_t> find_column(std::string_view name) const {
    return numbers_->find_column(name);
  }

  /// Advances to the next row, initially to the first one. False after the last.
  [[nodiscard]] bool next();
  // Of the current row:
  /// Its line in the file, from 1.
  [[nodiscard]] std::size_t line() const noexcept;
  /// One per column, valid until the next row; as many as it has, of a ragged table.
  [[nodiscard]] const std::vector<std::string_view>& cells() const noexcept;
  /// As those of CsvNumbers. Not checked: the row has the cell.
  [[nodiscard]] std::optional<double> number(std::size_t column) const;
  [[nodiscard]] std::optional<std::chrono::nanoseconds> time(std::size_t column) const;
  /// Throws the CsvError "column 'x': 'cell' is not <expected>" for a cell of the current row.
  [[noreturn]] void refuse(std::size_t column, const std::string& expected) const;

 private:
  struct Bytes;

  void take_separator_line(CsvFormat& format);
  void read_header(RowScanner& scanner, const CsvFormat& format, char delimiter);
  void look_through(RowScanner& scanner, const CsvFormat& format);

  std::unique_ptr<Bytes> bytes_;
  std::string_view text_;  // UTF-8, to the end of the last row
  std::size_t first_line_ = 1;
  std::size_t rows_ = 0;
  bool comments_ = false;
  std::vector<std::string> notes_;
  std::shared_ptr<CsvNumbers> collected_;
  std::shared_ptr<const CsvNumbers> numbers_;
  std::unique_ptr<RowScanner> scanner_;
};

}  // namespace pipescout
