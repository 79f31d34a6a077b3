// SPDX-License-Identifier: Apache-2.0
#include "path_track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kLongestStep = 1;  ///< m
/// Lattice paths use the whole steering, and rounding must not refuse them.
constexpr double kCurvatureTolerance = 1.02;
/// m, how far the robot may travel while the wheels turn for another curvature.
constexpr double kTransition = 0.6;

}  // namespace

PathTrack::PathTrack(const Path& path, const DrivingParameters& parameters)
    : poses_(path.poses()), braking_(parameters.gentle_braking) {
  if (poses_.empty()) {
    validation::refuse("path: has no poses");
  }
  const double largest = std::tan(parameters.largest_steering) / parameters.wheel_base;
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const double curvature = poses_[i].curvature;
    if (!(std::abs(curvature) <= largest * kCurvatureTolerance)) {
      validation::refuse("path: curvature ", curvature, " of pose ", i, " is outside [-", largest,
                         ", ", largest, "] 1/m");
    }
    if (i > 0 && poses_[i].arc_length - poses_[i - 1].arc_length > kLongestStep) {
      validation::refuse("path: step to pose ", i, " is longer than ", kLongestStep, " m");
    }
  }
  std::size_t first = 0;
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const bool last = i + 1 == poses_.size();
    if (last || poses_[i + 1].direction != poses_[first].direction) {
      // A direction that holds for one pose alone, the last one, is no way to drive.
      if (i > first || segments_.empty()) {
        segments_.push_back(
            {first, i, poses_[first].direction == Direction::kReverse ? -1.0 : 1.0});
      }
      first = i + 1;
    }
  }
  find_speeds(parameters);
}

void PathTrack::find_speeds(const DrivingParameters& parameters) {
  speeds_.assign(poses_.size(), 0);
  for (const Segment& segment : segments_) {
    const double most = segment.sign > 0 ? parameters.largest_speed : parameters.reverse_speed;
    for (std::size_t i = segment.first; i < segment.last; ++i) {
      const double curvature = std::abs(poses_[i].curvature);
      speeds_[i] =
          std::min(most, std::sqrt(parameters.lateral_acceleration / std::max(curvature, 1e-6)));
      if (i > segment.first) {
        const double turn = std::abs(std::atan(parameters.wheel_base * poses_[i].curvature) -
                                     std::atan(parameters.wheel_base * poses_[i - 1].curvature));
        if (turn > 0) {
          speeds_[i] = std::min(speeds_[i], kTransition * parameters.steering_rate / turn);
        }
      }
    }
    for (std::size_t i = segment.last; i-- > segment.first;) {
      const double step = poses_[i + 1].arc_length - poses_[i].arc_length;
      speeds_[i] =
          std::min(speeds_[i], std::sqrt(speeds_[i + 1] * speeds_[i + 1] + 2 * braking_ * step));
    }
  }
}

TrackPoint PathTrack::nearest(const Segment& segment, const TrackPoint& near, double reach,
                              const Point2d& position) const {
  std::size_t first = std::clamp(near.index, segment.first, segment.last);
  while (first > segment.first && poses_[first].arc_length > near.arc - reach) {
    --first;
  }
  TrackPoint best{first, poses_[first].arc_length, poses_[first].pose, poses_[first].curvature};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i < segment.last && poses_[i].arc_length <= near.arc + reach; ++i) {
    const Pose2d& a = poses_[i].pose;
    const Pose2d& b = poses_[i + 1].pose;
    const double dx = b.x - a.x;
    const double dy = b.y - a.y;
    const double square = dx * dx + dy * dy;
    const double share =
        square > 0
            ? std::clamp(((position.x - a.x) * dx + (position.y - a.y) * dy) / square, 0.0, 1.0)
            : 0.0;
    const double ex = position.x - (a.x + share * dx);
    const double ey = position.y - (a.y + share * dy);
    const double apart = ex * ex + ey * ey;
    if (apart < least) {
      least = apart;
      const double length = poses_[i + 1].arc_length - poses_[i].arc_length;
      best.index = i;
      best.arc = poses_[i].arc_length + share * length;
      best.curvature = poses_[i].curvature;
      best.pose = {a.x + share * dx, a.y + share * dy,
                   a.heading + share * wrap_angle(b.heading - a.heading)};
    }
  }
  return best;
}

TrackPoint PathTrack::at(const Segment& segment, const TrackPoint& near, double arc) const {
  std::size_t i = std::clamp(near.index, segment.first, segment.last);
  while (i > segment.first && poses_[i].arc_length > arc) {
    --i;
  }
  while (i + 1 < segment.last && poses_[i + 1].arc_length <= arc) {
    ++i;
  }
  const std::size_t next = std::min(i + 1, segment.last);
  const double length = poses_[next].arc_length - poses_[i].arc_length;
  const double share = length > 0 ? std::clamp((arc - poses_[i].arc_length) / length, 0.0, 1.0) : 0;
  const Pose2d& a = poses_[i].pose;
  const Pose2d& b = poses_[next].pose;
  return {i,
          poses_[i].arc_length + share * length,
          {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
           a.heading + share * wrap_angle(b.heading - a.heading)},
          poses_[i].curvature};
}

double PathTrack::allowed_speed(const TrackPoint& point) const {
  const std::size_t next = std::min(point.index + 1, poses_.size() - 1);
  const double step = std::max(0.0, poses_[next].arc_length - point.arc);
  const double later = speeds_[next];
  return std::min(speeds_[point.index], std::sqrt(later * later + 2 * braking_ * step));
}

}  // namespace pipescout::navigation
