// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "pipescout/command_line/text_table.hpp"

/// Values of ledgers as people read them.
namespace pipescout::ledger {

using command_line::TextTable;

/// For tables: metres to the millimetre.
inline TextTable::Cell metres(double value) {
  return std::isfinite(value) ? TextTable::Cell(std::round(value * 1000.0) / 1000.0)
                              : TextTable::Cell();
}

/// No value for an empty text.
inline TextTable::Cell text(const std::string& value) {
  return value.empty() ? TextTable::Cell() : TextTable::Cell(value);
}

inline TextTable::Cell number(std::size_t value) {
  return static_cast<std::int64_t>(value);
}

/// With up to 6 decimals: "0.500".
inline std::string fixed(double value, int decimals) {
  const double unit = std::pow(10.0, decimals);
  // Adding 0 turns -0 into 0.
  std::string digits = std::to_string(std::round(value * unit) / unit + 0.0);
  return digits.substr(0, digits.find('.') + 1 + static_cast<std::size_t>(decimals));
}

/// "1 weld", "2 welds".
inline std::string of(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace pipescout::ledger
