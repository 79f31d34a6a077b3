// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/pose2d.hpp"

#include <cmath>
#include <numbers>

namespace pipescout::navigation {

double wrap_angle(double angle) {
  constexpr double kTurn = 2 * std::numbers::pi;
  if (angle >= -std::numbers::pi && angle < std::numbers::pi) {
    return angle;
  }
  const double wrapped = std::remainder(angle, kTurn);
  return wrapped >= std::numbers::pi ? wrapped - kTurn : wrapped;
}

Pose2d compose(const Pose2d& T_A_B, const Pose2d& T_B_C) {
  const Point2d position = transform(T_A_B, T_B_C.position());
  return {position.x, position.y, wrap_angle(T_A_B.heading + T_B_C.heading)};
}

Pose2d relative(const Pose2d& T_A_B, const Pose2d& T_A_C) {
  const double cosine = std::cos(T_A_B.heading);
  const double sine = std::sin(T_A_B.heading);
  const double x = T_A_C.x - T_A_B.x;
  const double y = T_A_C.y - T_A_B.y;
  return {cosine * x + sine * y, cosine * y - sine * x, wrap_angle(T_A_C.heading - T_A_B.heading)};
}

Point2d transform(const Pose2d& T_A_B, const Point2d& p_B) {
  const double cosine = std::cos(T_A_B.heading);
  const double sine = std::sin(T_A_B.heading);
  return {T_A_B.x + cosine * p_B.x - sine * p_B.y, T_A_B.y + sine * p_B.x + cosine * p_B.y};
}

double distance(const Point2d& a, const Point2d& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

double distance(const Pose2d& a, const Pose2d& b) {
  return distance(a.position(), b.position());
}

bool is_finite(const Pose2d& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.heading);
}

}  // namespace pipescout::navigation
