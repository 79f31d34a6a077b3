// SPDX-License-Identifier: Apache-2.0
#include "pipescout/weld_locator/distance_history.hpp"

#include <algorithm>
#include <stdexcept>

namespace pipescout {

namespace {

DistanceHistory::Point between(const DistanceHistory::Point& a, const DistanceHistory::Point& b,
                               double share) {
  return {.time = a.time + from_seconds(share * to_seconds(b.time - a.time)),
          .distance = a.distance + share * (b.distance - a.distance),
          .uncalibrated = a.uncalibrated + share * (b.uncalibrated - a.uncalibrated)};
}

}  // namespace

DistanceHistory::DistanceHistory(std::size_t capacity) : points_(capacity) {
  if (capacity < 2) {
    throw std::invalid_argument("capacity: " + std::to_string(capacity) + " is below 2");
  }
}

bool DistanceHistory::add(const Point& point) {
  if (size_ > 0 && point.time <= latest().time) {
    return false;
  }
  points_[(first_ + size_) % points_.size()] = point;
  if (size_ == points_.size()) {
    first_ = (first_ + 1) % points_.size();
  } else {
    ++size_;
  }
  return true;
}

void DistanceHistory::clear() noexcept {
  size_ = 0;
}

std::optional<DistanceHistory::Point> DistanceHistory::at_time(Time time) const noexcept {
  if (size_ == 0 || time < at(0).time || time > latest().time) {
    return std::nullopt;
  }
  std::size_t low = 0;
  std::size_t high = size_ - 1;
  while (high - low > 1) {
    const std::size_t middle = low + (high - low) / 2;
    (at(middle).time <= time ? low : high) = middle;
  }
  const Point& before = at(low);
  const Point& after = at(high);
  if (low == high) {
    return before;
  }
  return between(before, after,
                 to_seconds(time - before.time) / to_seconds(after.time - before.time));
}

std::optional<DistanceHistory::Point> DistanceHistory::at_distance(double distance) const noexcept {
  for (std::size_t k = size_; k-- > 1;) {
    const Point& before = at(k - 1);
    const Point& after = at(k);
    const auto [low, high] = std::minmax(before.distance, after.distance);
    if (!(distance >= low && distance <= high)) {
      continue;
    }
    // Where it stands, the end of the stand is as good as any.
    const double share =
        high > low ? (distance - before.distance) / (after.distance - before.distance) : 1.0;
    return between(before, after, share);
  }
  return std::nullopt;
}

const DistanceHistory::Point& DistanceHistory::at(std::size_t k) const noexcept {
  return points_[(first_ + k) % points_.size()];
}

}  // namespace pipescout
