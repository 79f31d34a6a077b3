// SPDX-License-Identifier: Apache-2.0
#include "pipescout/crawler_simulation/route_file.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_reader.hpp"

namespace pipescout {

std::vector<simulation::RoutePiece> parse_route(std::string_view text, const std::string& path) {
  constexpr std::array kColumns{"length", "turn", "climb"};
  constexpr double kDegree = M_PI / 180;
  CsvReader reader(text, path);
  std::array<std::size_t, kColumns.size()> columns{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto column = reader.find_column(kColumns[i]);
    if (!column) {
      throw CsvError(path, reader.header_line(), "no column '" + std::string(kColumns[i]) + "'");
    }
    columns[i] = *column;
  }
  std::vector<simulation::RoutePiece> pieces;
  while (reader.next()) {
    std::array<double, kColumns.size()> values{};
    for (std::size_t i = 0; i < kColumns.size(); ++i) {
      const auto value = reader.number(columns[i]);
      if (!value || !std::isfinite(*value) || (i == 0 && *value <= 0)) {
        reader.refuse(columns[i], i == 0 ? "a positive number" : "a finite number");
      }
      values[i] = *value;
    }
    const auto [length, turn, climb] = values;
    pieces.push_back({.length = length,
                      .heading_rate = turn * kDegree / length,
                      .pitch_rate = climb * kDegree / length});
  }
  return pieces;
}

std::vector<simulation::RoutePiece> read_route(const std::string& path) {
  return parse_route(read_csv_text(path), path);
}

}  // namespace pipescout
