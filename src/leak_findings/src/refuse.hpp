// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace pipescout::leak_findings {

/// Throws std::invalid_argument with the parts as its message.
template <typename... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  std::ostringstream message;
  (message << ... << parts);
  throw std::invalid_argument(message.str());
}

/// What a finite number must be; NaN and infinities never are. `range` is for the message.
inline void require(const char* field, double value, bool in_range, const char* range) {
  if (!std::isfinite(value) || !in_range) {
    refuse(field, ": ", value, " is outside ", range);
  }
}

}  // namespace pipescout::leak_findings
