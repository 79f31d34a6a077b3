// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/runtime/stamp_limits.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// The last poses of the robot from odometry, to look up its pose at the time of an image.
class OdometryHistory {
 public:
  struct Entry {
    Time time;
    geometry::SE3 T_odom_base;
    geometry::Vector6d twist;  ///< [linear; angular] of the base in its own frame, m/s and rad/s
    /// Of the pose, as `covariance_from_message`.
    geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  };

  /// `longest_reach`: s beyond the last entry, or between two, over which a pose is still given.
  OdometryHistory(std::size_t capacity, double longest_reach);

  /// False, and nothing is stored, when `entry` is not later than the last one. An entry from long
  /// before (the clock was set back) restarts the history instead.
  bool add(const Entry& entry);
  void clear() { entries_.clear(); }

  /// Interpolated between two entries, extrapolated after the last one with its twist. Nothing
  /// before the first entry, or beyond the reach.
  [[nodiscard]] std::optional<geometry::SE3> at(Time time) const;
  /// Covariance of the last entry that is not later. Nothing when `at` returns nothing.
  [[nodiscard]] std::optional<geometry::Matrix6d> covariance_at(Time time) const;

 private:
  /// The first entry that is later than `time`; the one before it is within reach. Nothing
  /// otherwise.
  [[nodiscard]] std::optional<std::deque<Entry>::const_iterator> after(Time time) const;

  std::size_t capacity_;
  double longest_reach_;  // s
  std::deque<Entry> entries_;
};

/// What a component asks of odometry.
struct OdometryTerms {
  StampLimits stamps;
  std::string frame;              ///< of the header; empty: any
  bool needs_covariance = false;  ///< of the pose; else it is not read
};

/// As `Component::report_fault`.
using FaultReport = std::function<void(std::string_view counter, std::string_view text)>;

/// Stores a message, and returns what was stored: nothing when it is refused. `report` gets what is
/// wrong with it; a stale one is reported and stored.
std::optional<OdometryHistory::Entry> take_odometry(OdometryHistory& history,
                                                    const nav_msgs::msg::Odometry& message,
                                                    const OdometryTerms& terms, Time now,
                                                    const FaultReport& report);

}  // namespace pipescout
