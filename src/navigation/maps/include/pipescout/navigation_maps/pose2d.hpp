// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Poses in the plane. The x axis of a robot points forwards, its y axis to the left.
namespace pipescout::navigation {

/// A position, m.
struct Point2d {
  double x = 0;
  double y = 0;

  bool operator==(const Point2d&) const = default;
};

/// The pose of a frame B in a frame A, T_A_B: position in m, heading in rad counter-clockwise from
/// the x axis of A. No range is enforced for the heading.
struct Pose2d {
  double x = 0;
  double y = 0;
  double heading = 0;

  bool operator==(const Pose2d&) const = default;
  [[nodiscard]] Point2d position() const { return {x, y}; }
};

/// The same angle in [-pi, pi). NaN for what is not finite.
[[nodiscard]] double wrap_angle(double angle);

/// T_A_C of T_A_B and T_B_C; its heading is within [-pi, pi).
[[nodiscard]] Pose2d compose(const Pose2d& T_A_B, const Pose2d& T_B_C);

/// T_B_C of T_A_B and T_A_C: where C is, seen from B. Its heading is within [-pi, pi).
[[nodiscard]] Pose2d relative(const Pose2d& T_A_B, const Pose2d& T_A_C);

/// A point of B in A.
[[nodiscard]] Point2d transform(const Pose2d& T_A_B, const Point2d& p_B);

[[nodiscard]] double distance(const Point2d& a, const Point2d& b);
[[nodiscard]] double distance(const Pose2d& a, const Pose2d& b);

/// Position and heading are numbers, neither NaN nor infinite.
[[nodiscard]] bool is_finite(const Pose2d& pose);

}  // namespace pipescout::navigation
