// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/simulation/pipe_route.hpp>
#include <string>
#include <string_view>
#include <vector>

/// The file with the bends of a simulated pipe: CSV with the columns length (m), turn (degrees to
/// the left) and climb (degrees upwards), a row per stretch, over which the pipe bends evenly.
namespace pipescout {

/// Throws CsvError naming file and line: a column is missing, a cell is not a finite number, or a
/// length is not positive.
[[nodiscard]] std::vector<simulation::RoutePiece> read_route(const std::string& path);

/// The same from a text. `path` names it in errors.
[[nodiscard]] std::vector<simulation::RoutePiece> parse_route(std::string_view text,
                                                              const std::string& path);

}  // namespace pipescout
