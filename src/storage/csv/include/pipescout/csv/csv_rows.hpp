// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// CSV with quotes, for ledgers, tallies and lists of inspection runs. Pure functions.
namespace pipescout {

struct CsvRow {
  std::size_t line = 0;  ///< of its beginning, from 1
  std::vector<std::string> cells;
};

struct CsvRows {
  std::vector<CsvRow> rows;
  bool closed = true;  ///< false: a quote that is never closed begins in the last row
};

/// RFC 4180: quotes, doubled quotes, CRLF or LF; empty lines and a UTF-8 byte order mark are
/// ignored. A quote opens only at the beginning of a cell; elsewhere, as in 24", it is an ordinary
/// character. Rows may differ in their number of cells.
[[nodiscard]] CsvRows read_csv_rows(std::string_view text, char delimiter = ',');

/// Quoted by RFC 4180 if necessary.
[[nodiscard]] std::string csv_cell(std::string_view text);

/// As `format_csv_number`; empty for NaN, which means a missing value.
[[nodiscard]] std::string format_optional_csv_number(double value);

}  // namespace pipescout
