// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/csv/csv_format.hpp"

namespace pipescout {

/// How the numbers and times of a table are written, from all of its cells. A mark is taken for
/// that of decimals where a cell proves it ("0,5", "12.75", "1.234,5") and none the reverse; in
/// doubt ("1,234" alone) a cell is refused, with the setting that decides. Functions are
/// thread-safe when all cells have been seen.
class CsvNumbers {
 public:
  struct Header {
    std::string path;  ///< of the file
    std::size_t line = 0;
    std::vector<std::string> columns;  ///< names, `folded`
    std::vector<std::string> units;    ///< of a row below them; empty: none
  };
  CsvNumbers(Header header, CsvFormat format, char delimiter);

  /// For each cell of the table, before anything is asked.
  void see(std::size_t column, std::size_t line, std::string_view cell);

  [[nodiscard]] const std::string& path() const noexcept { return header_.path; }
  [[nodiscard]] std::size_t header_line() const noexcept { return header_.line; }
  [[nodiscard]] const std::vector<std::string>& columns() const noexcept { return header_.columns; }
  /// Compares `folded` names. Throws CsvError for a name that two columns have.
  [[nodiscard]] std::optional<std::size_t> find_column(std::string_view name) const;
  /// "mm" of a units row or of brackets in the column's name; empty: the file does not say.
  [[nodiscard]] std::string unit(std::size_t column) const;
  /// Whether all cells of the column are empty.
  [[nodiscard]] bool is_empty(std::size_t column) const;

  /// Nothing for text that is no number. nan, inf and -inf are numbers. Throws CsvError where the
  /// decimal mark is in doubt.
  [[nodiscard]] std::optional<double> number(std::size_t column, std::size_t line,
                                             std::string_view cell) const;
  /// A date and time, or a number in the unit that the settings, the units row, the name of the
  /// column or, of times since 1970, its size says; seconds otherwise. Negative times are possible.
  /// Nothing for other text. Throws CsvError where the unit is in doubt.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> time(std::size_t column, std::size_t line,
                                                             std::string_view cell) const;
  /// `time` in seconds.
  [[nodiscard]] std::optional<double> seconds(std::size_t column, std::size_t line,
                                              std::string_view cell) const;

  /// What was recognised of all numbers, for the user; empty: nothing out of the ordinary.
  [[nodiscard]] std::string note() const;
  /// The same of the times of a column.
  [[nodiscard]] std::string time_note(std::size_t column) const;

 private:
  /// Lines of the first cell of a kind; 0: none.
  struct Marks {
    std::size_t point = 0;
    std::size_t comma = 0;
    std::size_t maybe_point = 0;
    std::size_t maybe_comma = 0;
  };
  struct Column {
    Marks marks;
    std::size_t fewest_digits = 0;  // in front of the decimal mark, of numbers; 0: no numbers
    std::size_t most_digits = 0;
    std::size_t most_digits_line = 0;
    bool has_text = false;  // cells that are no numbers
    bool has_cells = false;
    bool has_zoneless_time = false;
  };
  enum class UnitSource { kSetting, kFile, kSize, kNone };
  struct FoundUnit {
    TimeUnit unit = TimeUnit::kSeconds;
    UnitSource source = UnitSource::kNone;
  };

  [[nodiscard]] char mark_of(std::size_t column) const;
  [[nodiscard]] FoundUnit time_unit_of(std::size_t column) const;
  [[noreturn]] void refuse(std::size_t column, std::size_t line, const std::string& what) const;

  Header header_;
  CsvFormat format_;
  char delimiter_;
  std::vector<Column> seen_;
  Marks all_;
};

}  // namespace pipescout
