// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

/// Single cells of the CSV that Pipescout writes: comma, decimal point. Pure functions;
/// thread-safe. Cells of other people's files: csv_reader.hpp.
namespace pipescout {

/// The number in a cell, which must contain nothing else: decimal, '.' as decimal point, exponent
/// allowed, or nan, inf, -inf in any case. Nothing for all other text and for numbers outside
/// double.
[[nodiscard]] std::optional<double> parse_csv_number(std::string_view cell);

/// With as many digits as a lossless round trip needs: "5.45", "1e-07", "nan", "-inf".
[[nodiscard]] std::string format_csv_number(double value);

/// As `format_csv_number`; empty for NaN, which means a missing value.
[[nodiscard]] std::string format_optional_csv_number(double value);

/// Quoted by RFC 4180 if necessary: also where blanks begin or end it, which readers drop.
[[nodiscard]] std::string csv_cell(std::string_view text);

}  // namespace pipescout
