// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/path.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {

Path::Path(std::vector<PathPose> poses) : poses_(std::move(poses)) {
  double driven = 0;
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const PathPose& pose = poses_[i];
    if (!is_finite(pose.pose) || !std::isfinite(pose.curvature)) {
      validation::refuse("path: pose ", i, " is not finite");
    }
    if (!(pose.arc_length >= driven) || !std::isfinite(pose.arc_length)) {
      validation::refuse("path: arc_length of pose ", i, " is ", pose.arc_length,
                         "; it must be at least ", driven);
    }
    driven = pose.arc_length;
  }
}

std::size_t Path::cusps() const {
  std::size_t count = 0;
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    count += poses_[i].direction != poses_[i - 1].direction ? 1 : 0;
  }
  return count;
}

double Path::reverse_length() const {
  double length = 0;
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    if (poses_[i - 1].direction == Direction::kReverse) {
      length += poses_[i].arc_length - poses_[i - 1].arc_length;
    }
  }
  return length;
}

double Path::largest_curvature() const {
  double largest = 0;
  for (const PathPose& pose : poses_) {
    largest = std::max(largest, std::abs(pose.curvature));
  }
  return largest;
}

PathPose Path::at(double arc_length) const {
  if (poses_.empty() || std::isnan(arc_length)) {
    validation::refuse("arc_length: ", arc_length, " asked of a path of ", poses_.size(), " poses");
  }
  const auto after =
      std::upper_bound(poses_.begin(), poses_.end(), arc_length,
                       [](double value, const PathPose& pose) { return value < pose.arc_length; });
  if (after == poses_.begin() || after == poses_.end()) {
    return after == poses_.end() ? poses_.back() : poses_.front();
  }
  const PathPose& from = *std::prev(after);
  const double share = (arc_length - from.arc_length) / (after->arc_length - from.arc_length);
  // Along the arc, then what its end misses of the next pose, in proportion.
  const double sign = from.direction == Direction::kForward ? 1 : -1;
  const double step = sign * (after->arc_length - from.arc_length);
  const Pose2d end = drive_arc(from.pose, from.curvature, step);
  PathPose result = from;
  result.pose = drive_arc(from.pose, from.curvature, share * step);
  result.pose.x += share * (after->pose.x - end.x);
  result.pose.y += share * (after->pose.y - end.y);
  result.pose.heading =
      wrap_angle(result.pose.heading + share * wrap_angle(after->pose.heading - end.heading));
  result.arc_length = arc_length;
  return result;
}

void Path::append(const Path& next) {
  const double driven = length();
  poses_.reserve(poses_.size() + next.poses_.size());
  for (const PathPose& pose : next.poses_) {
    poses_.push_back(pose);
    poses_.back().arc_length += driven;
  }
}

Pose2d drive_arc(const Pose2d& from, double curvature, double length) {
  const double turn = curvature * length;
  constexpr double kStraight = 1e-6;  // rad; the chord is then exact to 1e-13 of its length
  const double half = turn / 2;
  const double chord = std::abs(turn) < kStraight ? length : length * std::sin(half) / half;
  return {from.x + chord * std::cos(from.heading + half),
          from.y + chord * std::sin(from.heading + half), wrap_angle(from.heading + turn)};
}

}  // namespace pipescout::navigation
