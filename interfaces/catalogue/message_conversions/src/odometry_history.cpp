// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/odometry_history.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {
namespace {

/// A stamp that is earlier by more than this is of a clock that was set back.
constexpr Duration kLeap = std::chrono::seconds(10);

/// Everything except the covariance. Throws std::invalid_argument naming the field of an invalid
/// pose or twist.
OdometryHistory::Entry entry_of(const nav_msgs::msg::Odometry& message) {
  OdometryHistory::Entry entry;
  entry.time = from_message(message.header.stamp);
  entry.T_odom_base = from_message(message.pose.pose);
  entry.twist << from_message(message.twist.twist.linear),
      from_message(message.twist.twist.angular);
  if (!entry.twist.allFinite()) {
    throw std::invalid_argument("twist is not finite");
  }
  return entry;
}

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

std::optional<std::deque<OdometryHistory::Entry>::const_iterator> OdometryHistory::after(
    Time time) const {
  if (entries_.empty() || time < entries_.front().time) {
    return std::nullopt;
  }
  const auto after = std::ranges::upper_bound(entries_, time, {}, &Entry::time);
  const Time before = std::prev(after)->time;
  const Duration gap = (after == entries_.end() ? time : after->time) - before;
  return to_seconds(gap) > longest_reach_ ? std::nullopt : std::optional(after);
}

std::optional<geometry::SE3> OdometryHistory::at(Time time) const {
  const auto next = after(time);
  if (!next) {
    return std::nullopt;
  }
  const Entry& before = *std::prev(*next);
  const double since = to_seconds(time - before.time);
  if (*next == entries_.end()) {
    return before.T_odom_base * geometry::SE3::exp(since * before.twist);
  }
  const double interval = to_seconds((*next)->time - before.time);
  const geometry::Vector6d step = (before.T_odom_base.inverse() * (*next)->T_odom_base).log();
  return before.T_odom_base * geometry::SE3::exp(since / interval * step);
}

std::optional<geometry::Matrix6d> OdometryHistory::covariance_at(Time time) const {
  const auto next = after(time);
  return next ? std::optional(std::prev(*next)->covariance) : std::nullopt;
}

std::optional<OdometryHistory::Entry> take_odometry(OdometryHistory& history,
                                                    const nav_msgs::msg::Odometry& message,
                                                    const OdometryTerms& terms, Time now,
                                                    const FaultReport& report) {
  const Time stamp = from_message(message.header.stamp);
  if (const auto fault = terms.stamps.find_fault("odometry", stamp, now)) {
    report(fault->counter, fault->text);
    if (fault->in_future) {
      return std::nullopt;
    }
  }
  if (!terms.frame.empty() && message.header.frame_id != terms.frame) {
    report("odometry.header.frame_id",
           "odometry is in frame '" + message.header.frame_id + "', not in '" + terms.frame + "'");
    return std::nullopt;
  }
  OdometryHistory::Entry entry;
  try {
    entry = entry_of(message);
    if (terms.needs_covariance) {
      entry.covariance = covariance_from_message(message.pose.covariance);
    }
  } catch (const std::invalid_argument& error) {
    report("odometry.refused", std::string("odometry refused: ") + error.what());
    return std::nullopt;
  }
  if (!history.add(entry)) {
    report("odometry.header.stamp.not_increasing",
           "odometry has a stamp that is not later than the previous one");
    return std::nullopt;
  }
  return entry;
}

}  // namespace pipescout
