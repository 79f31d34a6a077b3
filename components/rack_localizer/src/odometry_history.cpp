// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_localizer/odometry_history.hpp"

#include <algorithm>
#include <chrono>

namespace pipescout {
namespace {

/// A stamp that is earlier by more than this is of a clock that was set back.
constexpr Duration kLeap = std::chrono::seconds(10);

}  // namespace

OdometryHistory::OdometryHistory(std::size_t capacity, double longest_reach)
    : capacity_(capacity), longest_reach_(longest_reach) {}

bool OdometryHistory::add(const Entry& entry) {
  if (!entries_.empty() && entry.time <= entries_.back().time) {
    if (entries_.back().time - entry.time < kLeap) {
      return false;
    }
    entries_.clear();
  }
  if (entries_.size() == capacity_) {
    entries_.pop_front();
  }
  entries_.push_back(entry);
  return true;
}

std::optional<geometry::SE3> OdometryHistory::at(Time time) const {
  if (entries_.empty() || time < entries_.front().time) {
    return std::nullopt;
  }
  const auto after = std::ranges::upper_bound(entries_, time, {}, &Entry::time);
  const Entry& before = *std::prev(after);
  const double since = to_seconds(time - before.time);
  if (after == entries_.end()) {
    if (since > longest_reach_) {
      return std::nullopt;
    }
    return before.T_odom_base * geometry::SE3::exp(since * before.twist);
  }
  const double interval = to_seconds(after->time - before.time);
  if (interval > longest_reach_) {
    return std::nullopt;
  }
  const geometry::Vector6d step = (before.T_odom_base.inverse() * after->T_odom_base).log();
  return before.T_odom_base * geometry::SE3::exp(since / interval * step);
}

}  // namespace pipescout
