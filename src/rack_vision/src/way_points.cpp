// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/way_points.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "pipescout/validation/check.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kFarthest = 1e5;      // m
constexpr double kLongestHold = 3600;  // s
// Largest slope of 3 t^2 - 2 t^3, the share of the cruise speed on the unit ramp.
constexpr double kSteepest = 1.5;

struct Progress {
  double value = 0;
  double rate = 0;
  double acceleration = 0;
};

// The ramp from 0 to the cruise rate: rate (3 x^2 - 2 x^3) at the share x of its time.
Progress on_ramp(double rate, double ramp, double time) {
  const double x = time / ramp;
  return {.value = rate * ramp * x * x * x * (1 - x / 2),
          .rate = rate * x * x * (3 - 2 * x),
          .acceleration = rate / ramp * 6 * x * (1 - x)};
}

}  // namespace

double wrap_angle(double angle) noexcept {
  const double wrapped = std::remainder(angle, 2 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

void WayPointPathParameters::validate() const {
  using validation::check_above;
  check_above("largest_speed", largest_speed, 0, 20);
  check_above("largest_acceleration", largest_acceleration, 0, 20);
  check_above("largest_yaw_rate", largest_yaw_rate, 0, 6);
  check_above("largest_yaw_acceleration", largest_yaw_acceleration, 0, 20);
}

WayPointPath::WayPointPath(std::span<const WayPoint> way_points,
                           const WayPointPathParameters& parameters)
    : way_points_(way_points.begin(), way_points.end()) {
  parameters.validate();
  if (way_points_.empty() || way_points_.size() > kMostWayPoints) {
    validation::refuse("way_points: ", way_points_.size(), " of them is outside [1, ",
                       kMostWayPoints, "]");
  }
  for (std::size_t i = 0; i < way_points_.size(); ++i) {
    const std::string name = "way_points[" + std::to_string(i) + "].";
    for (const double coordinate : way_points_[i].position) {
      validation::check_within(name + "position", coordinate, -kFarthest, kFarthest);
    }
    validation::check_within(name + "yaw", way_points_[i].yaw, -kFarthest, kFarthest);
    validation::check_within(name + "hold", way_points_[i].hold, 0, kLongestHold);
  }

  stays_.push_back({.arrival = 0, .departure = way_points_.front().hold});
  for (std::size_t i = 1; i < way_points_.size(); ++i) {
    Leg leg{.displacement = way_points_[i].position - way_points_[i - 1].position,
            .turn = wrap_angle(way_points_[i].yaw - way_points_[i - 1].yaw)};
    const double length = leg.displacement.norm();
    const double turn = std::abs(leg.turn);
    double duration = 0;
    if (length > 0 || turn > 0) {
      // 1/rate and 1/acceleration of the progress: the slower of the two motions rules.
      const double slowness =
          std::max(length / parameters.largest_speed, turn / parameters.largest_yaw_rate);
      const double inertia = std::max(length / parameters.largest_acceleration,
                                      turn / parameters.largest_yaw_acceleration);
      // Both ramps together cover rate * ramp = kSteepest rate^2 inertia, which must not pass 1.
      leg.rate = std::min(1 / slowness, 1 / std::sqrt(kSteepest * inertia));
      leg.ramp = kSteepest * leg.rate * inertia;
      leg.cruise = std::max(0.0, 1 / leg.rate - leg.ramp);
      duration = 2 * leg.ramp + leg.cruise;
    }
    const double arrival = stays_.back().departure + duration;
    legs_.push_back(leg);
    stays_.push_back({.arrival = arrival, .departure = arrival + way_points_[i].hold});
  }
}

PathPoint WayPointPath::at(double time) const noexcept {
  const double bounded = std::isnan(time) ? 0 : std::clamp(time, 0.0, duration());
  // The first way-point that it has not left before.
  const auto stay = std::ranges::lower_bound(stays_, bounded, {}, &Stay::departure);
  const auto index = static_cast<std::size_t>(stay - stays_.begin());
  const WayPoint& goal = way_points_[index];
  if (bounded >= stay->arrival) {
    return {.position = goal.position, .yaw = wrap_angle(goal.yaw), .way_point = index};
  }

  const Leg& leg = legs_[index - 1];
  const WayPoint& from = way_points_[index - 1];
  const double flown = bounded - stays_[index - 1].departure;
  Progress progress;
  if (flown < leg.ramp) {
    progress = on_ramp(leg.rate, leg.ramp, flown);
  } else if (flown < leg.ramp + leg.cruise) {
    progress = {.value = leg.rate * (flown - leg.ramp / 2), .rate = leg.rate};
  } else {
    progress = on_ramp(leg.rate, leg.ramp, stay->arrival - bounded);
    progress.value = 1 - progress.value;
    progress.acceleration = -progress.acceleration;
  }
  return {.position = from.position + progress.value * leg.displacement,
          .velocity = progress.rate * leg.displacement,
          .acceleration = progress.acceleration * leg.displacement,
          .yaw = wrap_angle(from.yaw + progress.value * leg.turn),
          .yaw_rate = progress.rate * leg.turn,
          .yaw_acceleration = progress.acceleration * leg.turn,
          .way_point = index,
          .holding = false};
}

void ReachedTolerance::validate() const {
  validation::check_above("tolerance.position", position, 0, 10);
  validation::check_above("tolerance.yaw", yaw, 0, std::numbers::pi);
}

bool is_reached(const WayPoint& way_point, const Eigen::Vector3d& position, double yaw,
                const ReachedTolerance& tolerance) noexcept {
  return (position - way_point.position).norm() <= tolerance.position &&
         std::abs(wrap_angle(yaw - way_point.yaw)) <= tolerance.yaw;
}

}  // namespace pipescout::rack_vision
