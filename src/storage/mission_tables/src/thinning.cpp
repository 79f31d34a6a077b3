// SPDX-License-Identifier: Apache-2.0
#include "pipescout/recording/thinning.hpp"

#include <algorithm>
#include <chrono>

namespace pipescout {

bool Thinning::due(Time stamp) const noexcept {
  const Duration early = std::min<Duration>(period_ / 100, std::chrono::milliseconds(5));
  return !last_ || stamp >= *last_ + period_ - early || stamp < *last_;
}

}  // namespace pipescout
