// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "pipescout/rack_vision/way_points.hpp"

namespace pipescout::rack_vision {
namespace {

/// In [from, to], in thousandths. At full size always: rapidcheck's small first cases would all be
/// next to 0.
double draw(int from, int to) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(from * 1000, to * 1000 + 1)) * 1e-3;
}

WayPoint draw_way_point() {
  return {
      .position = {draw(-5, 5), draw(-20, 20), draw(1, 6)}, .yaw = draw(-7, 7), .hold = draw(0, 3)};
}

WayPointPathParameters draw_parameters() {
  return {.largest_speed = 0.05 + draw(0, 3),
          .largest_acceleration = 0.05 + draw(0, 3),
          .largest_yaw_rate = 0.05 + draw(0, 2),
          .largest_yaw_acceleration = 0.05 + draw(0, 2)};
}

WayPointPath draw_path(const WayPointPathParameters& parameters) {
  std::vector<WayPoint> points(*rc::gen::inRange<std::size_t>(2, 6));
  std::ranges::generate(points, draw_way_point);
  return {points, parameters};
}

RC_GTEST_PROP(WayPointPathProperty, KeepsItsLimitsAndItsDerivativesAreThoseOfItsPosition, ()) {
  const WayPointPathParameters parameters = draw_parameters();
  const WayPointPath path = draw_path(parameters);
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 50; ++i) {
    const double time = draw(0, 1000) / 1000 * path.duration();
    const PathPoint before = path.at(time - kStep);
    const PathPoint now = path.at(time);
    const PathPoint after = path.at(time + kStep);
    RC_ASSERT(now.velocity.norm() <= parameters.largest_speed * (1 + 1e-9));
    RC_ASSERT(now.acceleration.norm() <= parameters.largest_acceleration * (1 + 1e-9));
    RC_ASSERT(std::abs(now.yaw_rate) <= parameters.largest_yaw_rate * (1 + 1e-9));
    RC_ASSERT(std::abs(now.yaw_acceleration) <= parameters.largest_yaw_acceleration * (1 + 1e-9));
    RC_ASSERT(std::abs(now.yaw) <= 3.141592653589794);
    const Eigen::Vector3d velocity = (after.position - before.position) / (2 * kStep);
    RC_ASSERT((velocity - now.velocity).norm() <= parameters.largest_acceleration * kStep);
    const double yaw_rate = wrap_angle(after.yaw - before.yaw) / (2 * kStep);
    RC_ASSERT(std::abs(yaw_rate - now.yaw_rate) <= parameters.largest_yaw_acceleration * kStep);
    const Eigen::Vector3d acceleration = (after.velocity - before.velocity) / (2 * kStep);
    // The mean over an interval lies within what the value takes on over it.
    const double change = (after.acceleration - before.acceleration).norm();
    RC_ASSERT((acceleration - now.acceleration).norm() <= change + 1e-6);
  }
}

RC_GTEST_PROP(WayPointPathProperty, AccelerationIsContinuous, ()) {
  const WayPointPathParameters parameters = draw_parameters();
  const WayPointPath path = draw_path(parameters);
  for (std::size_t i = 0; i < path.way_points().size(); ++i) {
    // Where legs and stays meet, and nowhere can it jump elsewhere: ramps and cruise meet at 0 too.
    for (const double time : {path.arrival(i), path.departure(i)}) {
      RC_ASSERT(path.at(time - 1e-7).acceleration.norm() < 1e-3);
      RC_ASSERT(path.at(time + 1e-7).acceleration.norm() < 1e-3);
      RC_ASSERT(path.at(time - 1e-7).velocity.norm() < 1e-3);
      RC_ASSERT(path.at(time + 1e-7).velocity.norm() < 1e-3);
    }
  }
}

RC_GTEST_PROP(WayPointPathProperty, IsAtEachWayPointFromArrivalToDeparture, ()) {
  const WayPointPath path = draw_path(draw_parameters());
  for (std::size_t i = 0; i < path.way_points().size(); ++i) {
    const WayPoint& way_point = path.way_points()[i];
    RC_ASSERT(path.departure(i) - path.arrival(i) - way_point.hold < 1e-9);
    for (const double time : {path.arrival(i), path.departure(i)}) {
      const PathPoint point = path.at(time);
      RC_ASSERT((point.position - way_point.position).norm() < 1e-9);
      RC_ASSERT(std::abs(wrap_angle(point.yaw - way_point.yaw)) < 1e-9);
    }
  }
}

}  // namespace
}  // namespace pipescout::rack_vision
