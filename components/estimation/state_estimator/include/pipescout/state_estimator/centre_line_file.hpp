// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/estimation/pipe_centre_line.hpp>
#include <string>
#include <string_view>

/// The file with the centre line of a pipe: CSV with the columns x, y, z (m, in the map), a row per
/// point, in the order of chainage; other columns are not read.
namespace pipescout {

/// `first_chainage`: m, of the first point. Throws CsvError naming file and line: a column is
/// missing, a cell is not a finite number, there are fewer than two points, or two neighbours are
/// one.
[[nodiscard]] estimation::PipeCentreLine read_centre_line(const std::string& path,
                                                          double first_chainage);

/// The same from a text. `path` names it in errors.
[[nodiscard]] estimation::PipeCentreLine parse_centre_line(std::string_view text,
                                                           const std::string& path,
                                                           double first_chainage);

}  // namespace pipescout
