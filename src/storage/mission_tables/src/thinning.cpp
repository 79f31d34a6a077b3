// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_tables/thinning.hpp"

#include <algorithm>
#include <chrono>

namespace pipescout {

bool Thinning::due(Stamp stamp) const noexcept {
  const std::chrono::nanoseconds early =
      std::min<std::chrono::nanoseconds>(period_ / 100, std::chrono::milliseconds(5));
  return !last_ || stamp >= *last_ + period_ - early || stamp < *last_;
}

}  // namespace pipescout
