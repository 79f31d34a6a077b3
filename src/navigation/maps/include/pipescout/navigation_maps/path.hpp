// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "pipescout/navigation_maps/pose2d.hpp"

namespace pipescout::navigation {

enum class Direction { kForward, kReverse };

/// One pose of a path, and how the path leaves it.
struct PathPose {
  Pose2d pose;  ///< T_map_robot
  /// In which the robot drives on from here; of the last pose: in which it arrived.
  Direction direction = Direction::kForward;
  double curvature =
      0;  ///< 1/m, of the way on, positive to the left of a robot that looks forwards
  double arc_length = 0;  ///< m, driven from the start to here; never falls

  bool operator==(const PathPose&) const = default;
};

/// What an Ackermann robot drives, as densely sampled poses. At a cusp two poses follow each other
/// at the same place, which differ in their direction.
class Path {
 public:
  Path() = default;
  /// Throws std::invalid_argument for poses that are not finite, and arc lengths that fall.
  explicit Path(std::vector<PathPose> poses);

  [[nodiscard]] const std::vector<PathPose>& poses() const { return poses_; }
  [[nodiscard]] bool empty() const { return poses_.empty(); }
  /// m; 0 for an empty path.
  [[nodiscard]] double length() const { return poses_.empty() ? 0 : poses_.back().arc_length; }
  /// How often the direction changes.
  [[nodiscard]] std::size_t cusps() const;
  /// m driven in reverse.
  [[nodiscard]] double reverse_length() const;
  /// 1/m, the largest amount of any curvature.
  [[nodiscard]] double largest_curvature() const;
  /// The pose at an arc length, held within the path: between two poses along the arc that joins
  /// them. Throws std::invalid_argument for an empty path or NaN.
  [[nodiscard]] PathPose at(double arc_length) const;
  /// `next` begins where this path ends; its arc lengths go on from there.
  void append(const Path& next);

  bool operator==(const Path&) const = default;

 private:
  std::vector<PathPose> poses_;
};

/// The pose after driving `length` m (negative: in reverse) with a curvature in 1/m.
[[nodiscard]] Pose2d drive_arc(const Pose2d& from, double curvature, double length);

}  // namespace pipescout::navigation
