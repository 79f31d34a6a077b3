// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/csv/csv_reader.hpp"
#include "pipescout/csv/csv_stamp.hpp"

/// Odometer readings as CSV, the format of the replay and of a mission's data files. Columns:
///
///   stamp                      optional: time of measurement, s since the Unix epoch or any other
///                              start, 0 <= stamp < 2^31, strictly increasing
///   reading                    optional: a whole number, strictly increasing; for people
///   NAME                       one per odometer: distance, m; nan, inf and -inf are legal
///   NAME.standard_deviation    optional, for all odometers or none: m; any number is legal
///   NAME.valid                 optional: 1 or 0; without it readings are valid
///
/// Tables of other programs are read as CsvReader reads them: stamps may be dates and times or in
/// another unit, and distances in the unit of a units row or of brackets in the column's name. All
/// values that a driver can report are legal, including those of a fault: the fusion rejects them.
namespace pipescout {

/// Selection of columns.
struct ReadingsCsvSelection {
  /// Odometers and their order. Empty: all remaining columns, in the file's order.
  std::vector<std::string> odometers;
  /// Columns that are not odometers. They may be absent.
  std::vector<std::string> ignored_columns;
  /// How the table is written, as far as the user says it.
  CsvFormat format{};
};

/// One row. The lists are as long as `ReadingsRecording::odometers`.
struct ReadingsRow {
  std::chrono::nanoseconds stamp{};        ///< zero without stamps in the file
  std::vector<double> distance;            ///< m
  std::vector<double> standard_deviation;  ///< m; empty without such columns
  std::vector<bool> valid;
};

/// A whole file in row-major lists.
struct ReadingsRecording {
  std::vector<std::string> odometers;
  std::vector<std::chrono::nanoseconds> stamps;  ///< one per row; empty without such a column
  std::vector<double> distances;                 ///< m, one per row and odometer
  std::vector<double> standard_deviations;       ///< m, the same; empty without such columns
  std::vector<bool> valid;                       ///< one per row and odometer
  std::vector<std::string> notes;                ///< how the file was read, where that is a guess

  /// Rows; at least one in what `parse_readings_csv` returns.
  [[nodiscard]] std::size_t size() const noexcept {
    return odometers.empty() ? 0 : distances.size() / odometers.size();
  }
  /// A copy of a row. Not checked: `index` < size().
  [[nodiscard]] ReadingsRow row(std::size_t index) const;
};

/// Throws CsvError, naming file and line, for what CsvReader refuses, columns without a name or of
/// one name, a selected odometer that has no column, no odometer column at all, a unit that is no
/// length, a cell of the wrong kind for its column, and stamps or reading numbers out of order.
/// Uses no more memory than the final recording, if the table is UTF-8.
[[nodiscard]] ReadingsRecording parse_readings_csv(std::string_view bytes, std::string_view path,
                                                   const ReadingsCsvSelection& selection = {});

/// Valid column names: characters and names that this CSV does not have (commas, quotes, control
/// characters, blanks at the ends, bytes that are not UTF-8, the suffixes above) are replaced by
/// '_', runs of blanks by one, and an empty or duplicate name or one above becomes
/// "odometer_<its number>".
[[nodiscard]] std::vector<std::string> odometer_column_names(const std::vector<std::string>& names);

/// The header line, without line end; `columns` as of `odometer_column_names`.
[[nodiscard]] std::string format_readings_header(const std::vector<std::string>& columns,
                                                 bool with_standard_deviations);
/// One row below that header. Stamp and values are preserved by writing and reading, unless
/// `parse_stamp` refuses the stamp.
[[nodiscard]] std::string format_readings_row(std::uint64_t reading, const ReadingsRow& row);

}  // namespace pipescout
