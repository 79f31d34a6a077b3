// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "pipescout/csv/csv_line.hpp"
#include "pipescout/mission_folder/mission_section.hpp"

/// What the makers of tables share: numbers in sections and lines, and refusal of messages. Pure.
namespace pipescout::summary {

/// To so many parts of the unit: with 1000, thousandths.
[[nodiscard]] inline double rounded(double value, double parts) {
  return std::round(value * parts) / parts;
}

/// The same; no value when it is not finite.
[[nodiscard]] inline MissionCell rounded_cell(double value, double parts) {
  return std::isfinite(value) ? MissionCell(rounded(value, parts)) : MissionCell();
}

[[nodiscard]] inline MissionCell count_cell(std::uint64_t value) {
  return static_cast<std::int64_t>(value);
}

/// An empty cell for a value that is not finite.
inline void add_or_empty(CsvLine& line, double value) {
  if (std::isfinite(value)) {
    line.add(value);
  } else {
    line.add_empty();
  }
}

/// Throws std::invalid_argument(`why`) unless it is good.
inline void require(bool good, const char* why) {
  if (!good) {
    throw std::invalid_argument(why);
  }
}

}  // namespace pipescout::summary
