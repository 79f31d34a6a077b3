// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "pipescout/driving/local_costmap.hpp"
#include "pipescout/navigation_maps/pose2d.hpp"

namespace pipescout::navigation {

/// A group of echoes that stays together, and how it moves.
struct MovingObstacle {
  Point2d centre;
  double radius = 0;  ///< m, around the centre
  double vx = 0;      ///< m/s
  double vy = 0;
  double seen = 0;        ///< s
  double first_seen = 0;  ///< s
};

/// Groups echoes by gaps and follows the groups from scan to scan: nearest neighbours with an
/// alpha-beta filter (Bar-Shalom, Li and Kirubarajan, 2001, section 6.5). Groups larger than
/// a vehicle are walls and are not followed. Allocates nothing.
class MovingObstacles {
 public:
  void clear() { count_ = 0; }
  void add(const ScanView& scan, const Pose2d& T_map_lidar);
  /// Those that are followed long enough and move.
  [[nodiscard]] std::span<const MovingObstacle> moving() const { return {moving_.data(), moved_}; }

 private:
  static constexpr std::size_t kMost = 64;

  void take(const MovingObstacle& group);

  std::array<MovingObstacle, kMost> tracks_{};
  std::size_t count_ = 0;
  std::array<MovingObstacle, kMost> moving_{};
  std::size_t moved_ = 0;
};

}  // namespace pipescout::navigation
