// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// The last poses of the robot from odometry, to tell where it was when an image was taken.
class OdometryHistory {
 public:
  struct Entry {
    Time time;
    geometry::SE3 T_odom_base;
    geometry::Vector6d twist;  ///< [linear; angular] of the base in its own frame, m/s and rad/s
    /// Of the pose, as `covariance_from_message`.
    geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
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
  /// Of the last entry that is not later. Nothing where `at` has nothing.
  [[nodiscard]] std::optional<geometry::Matrix6d> covariance_at(Time time) const;

 private:
  /// The first entry that is later than `time`; the one before it is within reach. Nothing
  /// otherwise.
  [[nodiscard]] std::optional<std::deque<Entry>::const_iterator> after(Time time) const;

  std::size_t capacity_;
  double longest_reach_;  // s
  std::deque<Entry> entries_;
};

/// All but the covariance, which not all who ask for poses need. Throws std::invalid_argument
/// naming the field of the pose or twist that is none.
[[nodiscard]] OdometryHistory::Entry odometry_entry(const nav_msgs::msg::Odometry& message);

}  // namespace pipescout
