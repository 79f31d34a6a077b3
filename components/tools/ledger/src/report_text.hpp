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

/// "1 weld", "2 welds".
inline std::string of(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace pipescout::ledger
