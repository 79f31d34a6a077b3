// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// History of the latest fused distances, linear in between. Bounded. Pure; not thread-safe.
class DistanceHistory {
 public:
  struct Point {
    Time time{};
    double distance = 0.0;      ///< m, of the fused odometer
    double uncalibrated = 0.0;  ///< m, the same without the calibration of the odometers
  };

  /// `capacity`: points, at least 2.
  explicit DistanceHistory(std::size_t capacity);

  /// False, and nothing is added, when the time is not later than that of the point before.
  bool add(const Point& point);
  void clear() noexcept;

  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  /// Not for an empty history.
  [[nodiscard]] const Point& latest() const noexcept { return at(size_ - 1); }
  [[nodiscard]] const Point& oldest() const noexcept { return at(0); }

  /// Nothing before the first and after the last point.
  [[nodiscard]] std::optional<Point> at_time(Time time) const noexcept;
  /// The last time at which the crawler was there.
  [[nodiscard]] std::optional<Point> at_distance(double distance) const noexcept;

 private:
  [[nodiscard]] const Point& at(std::size_t k) const noexcept;

  std::vector<Point> points_;  // a ring
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace pipescout
