// SPDX-License-Identifier: Apache-2.0
#include "moving_obstacles.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::navigation {
namespace {

constexpr double kGap = 0.5;          ///< m, between groups
constexpr double kFarthest = 15;      ///< m
constexpr double kLargestRadius = 2;  ///< m, of a vehicle
constexpr double kJump = 0.8;         ///< m, between scans
constexpr double kLeastSpeed = 0.3;   ///< m/s; slower is noise of the outline that is seen
constexpr double kLargestSpeed = 4;   ///< m/s
constexpr double kSettled = 0.3;      ///< s, followed
constexpr double kForgotten = 0.6;    ///< s, unseen
constexpr double kAlpha = 0.5;
constexpr double kBeta = 0.2;

}  // namespace

void MovingObstacles::take(const MovingObstacle& group) {
  MovingObstacle* nearest = nullptr;
  double least = kJump;
  for (std::size_t i = 0; i < count_; ++i) {
    MovingObstacle& track = tracks_[i];
    const double dt = group.seen - track.seen;
    const Point2d predicted{track.centre.x + track.vx * dt, track.centre.y + track.vy * dt};
    const double apart = distance(predicted, group.centre);
    if (dt > 0 && apart < least) {
      least = apart;
      nearest = &track;
    }
  }
  if (nearest == nullptr) {
    if (count_ < kMost) {
      tracks_[count_++] = group;
    }
    return;
  }
  const double dt = group.seen - nearest->seen;
  const Point2d predicted{nearest->centre.x + nearest->vx * dt,
                          nearest->centre.y + nearest->vy * dt};
  const double ex = group.centre.x - predicted.x;
  const double ey = group.centre.y - predicted.y;
  nearest->centre = {predicted.x + kAlpha * ex, predicted.y + kAlpha * ey};
  nearest->vx += kBeta * ex / dt;
  nearest->vy += kBeta * ey / dt;
  const double speed = std::hypot(nearest->vx, nearest->vy);
  if (speed > kLargestSpeed) {
    nearest->vx *= kLargestSpeed / speed;
    nearest->vy *= kLargestSpeed / speed;
  }
  nearest->radius = group.radius;
  nearest->seen = group.seen;
}

void MovingObstacles::add(const ScanView& scan, const Pose2d& T_map_lidar) {
  std::size_t points = 0;
  Point2d low;
  Point2d high;
  Point2d last;
  const auto close = [&] {
    const double radius = 0.5 * std::hypot(high.x - low.x, high.y - low.y);
    if (points >= 2 && radius < kLargestRadius) {
      take({.centre = {0.5 * (low.x + high.x), 0.5 * (low.y + high.y)},
            .radius = radius,
            .seen = scan.time,
            .first_seen = scan.time});
    }
    points = 0;
  };
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges[i]);
    if (!(range >= scan.range_min && range < std::min(scan.range_max, kFarthest))) {
      continue;
    }
    const double angle =
        T_map_lidar.heading + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const Point2d point{T_map_lidar.x + range * std::cos(angle),
                        T_map_lidar.y + range * std::sin(angle)};
    if (points > 0 && distance(point, last) > kGap) {
      close();
    }
    low = points == 0 ? point : Point2d{std::min(low.x, point.x), std::min(low.y, point.y)};
    high = points == 0 ? point : Point2d{std::max(high.x, point.x), std::max(high.y, point.y)};
    last = point;
    ++points;
  }
  close();
  const auto* end = std::remove_if(
      tracks_.begin(), tracks_.begin() + static_cast<std::ptrdiff_t>(count_),
      [&](const MovingObstacle& track) { return scan.time - track.seen > kForgotten; });
  count_ = static_cast<std::size_t>(end - tracks_.data());
  moved_ = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const MovingObstacle& track = tracks_[i];
    if (track.seen - track.first_seen >= kSettled &&
        std::hypot(track.vx, track.vy) >= kLeastSpeed) {
      moving_[moved_++] = track;
    }
  }
}

}  // namespace pipescout::navigation
