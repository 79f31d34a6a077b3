// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace pipescout::arm_study::internal {

/// Throws std::invalid_argument unless low <= value <= high.
inline void check_within(const std::string& field, double value, double low, double high) {
  if (!(value >= low && value <= high && std::isfinite(value))) {
    std::ostringstream message;
    message << field << ": " << value << " is outside [" << low << ", " << high << "]";
    throw std::invalid_argument(message.str());
  }
}

}  // namespace pipescout::arm_study::internal
