// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "pipescout/simulation/ground_robot.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {

using Eigen::Vector2d;

void CourseParameters::validate() const {
  using validation::check_above;
  using validation::check_within;
  check_above("speed", speed, 0, 20);
  check_above("slowest", slowest, 0, speed);
  check_above("gain", gain, 0, 10);
  check_within("look_ahead", look_ahead, 0.1, 100);
  check_within("reached", reached, 0.1, 100);
  check_above("sideways", sideways, 0, 10);
}

CourseController::CourseController(const CourseParameters& parameters,
                                   std::vector<Vector2d> way_points)
    : parameters_(parameters), way_points_(std::move(way_points)) {
  parameters_.validate();
  if (way_points_.empty() ||
      !std::ranges::all_of(way_points_, [](const Vector2d& p) { return p.allFinite(); })) {
    throw std::invalid_argument("way_points: it takes one at least, all finite");
  }
}

GroundRobotCommand CourseController::steer(const GroundRobot& robot) {
  const Vector2d place = robot.motion().T_map_body.translation().head<2>();
  if (!started_) {
    from_ = place;
    started_ = true;
  }
  while (!arrived() && (way_points_[next_] - place).norm() < parameters_.reached) {
    from_ = way_points_[next_];
    ++next_;
  }
  if (arrived()) {
    return {};
  }
  const Vector2d leg = way_points_[next_] - from_;
  const double length = leg.norm();
  const Vector2d along = length > 0 ? Vector2d(leg / length) : Vector2d::UnitX();
  const double ahead = std::min((place - from_).dot(along) + parameters_.look_ahead, length);
  const Vector2d aim = from_ + ahead * along - place;
  const double error =
      std::remainder(std::atan2(aim.y(), aim.x()) - robot.yaw(), 2 * std::numbers::pi);
  const double speed = std::max(parameters_.slowest, parameters_.speed * std::cos(error));
  const double largest = parameters_.sideways / std::max(std::abs(robot.speed()), 0.1);
  return {.speed = speed, .yaw_rate = std::clamp(parameters_.gain * error, -largest, largest)};
}

}  // namespace pipescout::simulation
