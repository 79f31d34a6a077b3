// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace pipescout::odometry {

struct CsvRow {
  std::size_t line = 0;  // of its beginning, from 1
  std::vector<std::string> cells;
};

/// RFC 4180: quotes, doubled quotes, CRLF or LF; empty lines are passed over. A quote that is never
/// closed ends with the text; `closed` says so.
struct CsvRows {
  std::vector<CsvRow> rows;
  bool closed = true;
};
[[nodiscard]] CsvRows read_csv_rows(std::string_view text);

/// Quoted when it must be.
[[nodiscard]] std::string csv_cell(const std::string& text);

/// Shortest decimal that brings back the bits; empty for NaN.
[[nodiscard]] std::string shortest(double value);

}  // namespace pipescout::odometry
