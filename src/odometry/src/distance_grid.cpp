// SPDX-License-Identifier: Apache-2.0
#include "distance_grid.hpp"

#include <algorithm>

namespace pipescout::odometry {

DistanceGrid::DistanceGrid(std::size_t rows, std::size_t capacity)
    : mask_(static_cast<std::int64_t>(capacity) - 1),
      stride_(2 * capacity),
      values_(rows * stride_, 0.0) {}

void DistanceGrid::extend(std::int64_t cell) noexcept {
  if (empty_) {
    low_ = high_ = cell;
    empty_ = false;
  } else if (cell > high_) {
    high_ = cell;
    low_ = std::max(low_, high_ - mask_);
  } else {
    low_ = cell;
    high_ = std::min(high_, low_ + mask_);
  }
}

}  // namespace pipescout::odometry
