// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/interfaces/time.hpp"

namespace pipescout {

/// The last poses of the robot from odometry, to tell where it was when an image was taken.
class OdometryHistory {
 public:
  struct Entry {
    Time time;
    geometry::SE3 T_odom_base;
    geometry::Vector6d twist;  ///< [linear; angular] of the base in its own frame, m/s and rad/s
  };

  /// `longest_reach`: s beyond the last entry, or between two, over which a pose is still told.
  OdometryHistory(std::size_t capacity, double longest_reach);

  /// False, and nothing is kept, when `entry` is not later than the last one. An entry from long
  /// before (a clock that was set back) begins the history anew instead.
  bool add(const Entry& entry);
  void clear() { entries_.clear(); }

  /// Between two entries interpolated, after the last one moved on by its twist. Nothing before the
  /// first entry, and beyond the reach.
  [[nodiscard]] std::optional<geometry::SE3> at(Time time) const;

 private:
  std::size_t capacity_;
  double longest_reach_;  // s
  std::deque<Entry> entries_;
};

}  // namespace pipescout
