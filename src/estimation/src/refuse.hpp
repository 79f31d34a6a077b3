// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace pipescout::estimation {

/// Throws std::invalid_argument unless `value` is finite and `in_range`. `range` is for the
/// message.
inline void require(const char* field, double value, bool in_range, const char* range) {
  if (!std::isfinite(value) || !in_range) {
    std::ostringstream message;
    message << field << ": " << value << " is outside " << range;
    throw std::invalid_argument(message.str());
  }
}

}  // namespace pipescout::estimation
