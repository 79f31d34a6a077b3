// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_tables/true_track.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>

namespace pipescout {

namespace {

/// Estimates come some while after their stamp.
constexpr std::size_t kMaximumPlaces = 4096;
constexpr std::chrono::nanoseconds kLongestBetween = std::chrono::milliseconds(200);

}  // namespace

bool TrueTrack::add(Stamp stamp, const geometry::SE3& pose) {
  const bool goes_on = places_.empty() || stamp > places_.back().stamp;
  if (!goes_on) {
    places_.clear();
  }
  if (places_.size() == kMaximumPlaces) {
    places_.pop_front();
  }
  places_.push_back({stamp, pose});
  return goes_on;
}

std::optional<geometry::SE3> TrueTrack::at(Stamp stamp) const {
  const auto after =
      std::lower_bound(places_.begin(), places_.end(), stamp,
                       [](const Place& place, Stamp time) { return place.stamp < time; });
  if (after == places_.end()) {
    return std::nullopt;
  }
  if (after->stamp == stamp) {
    return after->pose;
  }
  if (after == places_.begin()) {
    return std::nullopt;
  }
  const Place& before = *std::prev(after);
  if (after->stamp - before.stamp > kLongestBetween) {
    return std::nullopt;
  }
  const double share =
      std::chrono::duration<double>(stamp - before.stamp) / (after->stamp - before.stamp);
  const geometry::SO3& from = before.pose.rotation();
  const geometry::SO3& to = after->pose.rotation();
  const Eigen::Vector3d turn = share * (from.inverse() * to).log();
  return geometry::SE3(from * geometry::SO3::exp(turn), (1.0 - share) * before.pose.translation() +
                                                            share * after->pose.translation());
}

}  // namespace pipescout
