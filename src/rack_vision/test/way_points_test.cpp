// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/way_points.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kPi = std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <typename Function>
std::string message_of(const Function& function) {
  try {
    function();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(WrapAngle, LeavesTheHalfOpenCircle) {
  EXPECT_EQ(wrap_angle(1), 1);
  EXPECT_EQ(wrap_angle(kPi), kPi);
  EXPECT_EQ(wrap_angle(-kPi), kPi);
  EXPECT_NEAR(wrap_angle(2 * kPi + 0.1), 0.1, 1e-12);
  EXPECT_NEAR(wrap_angle(-1000 * kPi - 0.1), -0.1, 1e-9);
}

TEST(WayPointPath, CruisesOnALongLeg) {
  // 4 m at 0.4 m/s: the ramps take 1.5 * 0.4 / 0.5 = 1.2 s each and cover 0.24 m each, so the
  // cruise takes (4 - 0.48) / 0.4 = 8.8 s.
  const std::vector<WayPoint> points{{.position = {0, 0, 3}, .hold = 1},
                                     {.position = {0, 4, 3}, .hold = 2}};
  const WayPointPath path(points, {});
  EXPECT_NEAR(path.arrival(1), 1 + 2 * 1.2 + 8.8, 1e-12);
  EXPECT_NEAR(path.duration(), path.arrival(1) + 2, 1e-12);

  const PathPoint middle = path.at(1 + 1.2 + 4.4);
  EXPECT_LT((middle.position - Vector3d(0, 2, 3)).norm(), 1e-12);
  EXPECT_LT((middle.velocity - Vector3d(0, 0.4, 0)).norm(), 1e-12);
  EXPECT_EQ(middle.acceleration.norm(), 0);
  EXPECT_FALSE(middle.holding);
  EXPECT_EQ(middle.way_point, 1U);

  const PathPoint steepest = path.at(1 + 0.6);
  EXPECT_LT((steepest.acceleration - Vector3d(0, 0.5, 0)).norm(), 1e-12);
  EXPECT_LT((steepest.velocity - Vector3d(0, 0.2, 0)).norm(), 1e-12);
  // The ramp 0.4 * 1.2 * (x^3 - x^4 / 2) at x = 1/2.
  EXPECT_NEAR(steepest.position.y(), 0.48 * (0.125 - 0.03125), 1e-12);
  EXPECT_LT((path.at(path.arrival(1) - 0.6).acceleration + Vector3d(0, 0.5, 0)).norm(), 1e-9);
}

TEST(WayPointPath, DoesNotReachItsCruiseOnAShortLeg) {
  // Two ramps alone: 1.5 v^2 / a = 0.1 m gives v = sqrt(0.1 * 0.5 / 1.5).
  const std::vector<WayPoint> points{{.position = {0, 0, 3}, .hold = 0},
                                     {.position = {0.1, 0, 3}, .hold = 0}};
  const WayPointPath path(points, {});
  const double fastest = std::sqrt(0.1 * 0.5 / 1.5);
  EXPECT_NEAR(path.duration(), 2 * 1.5 * fastest / 0.5, 1e-12);
  EXPECT_NEAR(path.at(path.duration() / 2).velocity.x(), fastest, 1e-9);
  EXPECT_NEAR(path.at(path.duration() / 2).position.x(), 0.05, 1e-12);
  EXPECT_LT((path.at(path.duration()).position - Vector3d(0.1, 0, 3)).norm(), 1e-12);
}

TEST(WayPointPath, TurnsTheShortWay) {
  const std::vector<WayPoint> points{{.position = {1, 2, 3}, .yaw = 3, .hold = 0},
                                     {.position = {1, 2, 3}, .yaw = -3, .hold = 0}};
  const WayPointPath path(points, {});
  const PathPoint middle = path.at(path.duration() / 2);
  EXPECT_NEAR(std::abs(middle.yaw), kPi, 1e-9);
  EXPECT_GT(middle.yaw_rate, 0);
  EXPECT_LE(middle.yaw_rate, 0.16);
  EXPECT_LT((middle.position - Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_NEAR(path.at(path.duration()).yaw, -3, 1e-12);
}

TEST(WayPointPath, TakesTheTimeOfTheSlowerMotion) {
  const std::vector<WayPoint> points{{.position = {0, 0, 3}, .yaw = 0, .hold = 0},
                                     {.position = {0.5, 0, 3}, .yaw = 2, .hold = 0}};
  const WayPointPath path(points, {});
  const PathPoint middle = path.at(path.duration() / 2);
  EXPECT_NEAR(middle.yaw_rate, 0.16, 1e-12);
  EXPECT_NEAR(middle.velocity.x(), 0.16 / 2 * 0.5, 1e-12);
}

TEST(WayPointPath, StaysAtOneWayPoint) {
  const std::vector<WayPoint> points{{.position = {1, 2, 3}, .yaw = 7, .hold = 4}};
  const WayPointPath path(points, {});
  EXPECT_EQ(path.duration(), 4);
  for (const double time : {-1.0, 0.0, 2.0, 4.0, 100.0, kNaN}) {
    const PathPoint point = path.at(time);
    EXPECT_EQ(point.position, Vector3d(1, 2, 3));
    EXPECT_NEAR(point.yaw, 7 - 2 * kPi, 1e-12);
    EXPECT_TRUE(point.holding);
  }
}

TEST(WayPointPath, PassesTheSamePlaceTwice) {
  const WayPoint point{.position = {1, 2, 3}, .hold = 1};
  const std::vector<WayPoint> points{point, point, point};
  const WayPointPath path(points, {});
  EXPECT_EQ(path.duration(), 3);
  EXPECT_EQ(path.at(2.5).way_point, 2U);
  EXPECT_EQ(path.at(2.5).velocity.norm(), 0);
}

TEST(WayPointPath, RejectsWhatIsOutOfRange) {
  const auto made_of = [](const std::vector<WayPoint>& points,
                          const WayPointPathParameters& parameters = {}) {
    return message_of([&] { const WayPointPath path(points, parameters); });
  };
  EXPECT_THAT(made_of({}), HasSubstr("way_points: 0"));
  EXPECT_THAT(made_of(std::vector<WayPoint>(1001)), HasSubstr("way_points: 1001"));
  EXPECT_THAT(made_of({{}, {.position = {0, kNaN, 0}}}), HasSubstr("way_points[1].position: nan"));
  EXPECT_THAT(made_of({{.position = {2e5, 0, 0}}}), HasSubstr("way_points[0].position: 200000"));
  EXPECT_THAT(made_of({{.yaw = kNaN}}), HasSubstr("way_points[0].yaw"));
  EXPECT_THAT(made_of({{.hold = -1}}), HasSubstr("way_points[0].hold: -1"));
  EXPECT_THAT(made_of({{}}, {.largest_speed = 0}), HasSubstr("largest_speed: 0"));
  EXPECT_THAT(made_of({{}}, {.largest_acceleration = -1}), HasSubstr("largest_acceleration"));
  EXPECT_THAT(made_of({{}}, {.largest_yaw_rate = 7}), HasSubstr("largest_yaw_rate: 7"));
  EXPECT_THAT(made_of({{}}, {.largest_yaw_acceleration = kNaN}),
              HasSubstr("largest_yaw_acceleration"));
  EXPECT_EQ(made_of({{}}), "");
}

TEST(ReachedTolerance, IsOfPositionAndYawTheShortWay) {
  const WayPoint point{.position = {1, 2, 3}, .yaw = kPi - 0.005};
  const ReachedTolerance tolerance;
  EXPECT_TRUE(is_reached(point, {1, 2.029, 3}, -kPi + 0.005, tolerance));
  EXPECT_FALSE(is_reached(point, {1, 2.031, 3}, kPi, tolerance));
  EXPECT_FALSE(is_reached(point, {1, 2, 3}, kPi - 0.03, tolerance));
  EXPECT_FALSE(is_reached(point, {1, kNaN, 3}, kPi, tolerance));
  EXPECT_FALSE(is_reached(point, {1, 2, 3}, kNaN, tolerance));
  EXPECT_THAT(message_of([] { ReachedTolerance{.position = 0}.validate(); }),
              HasSubstr("tolerance.position: 0"));
  EXPECT_THAT(message_of([] { ReachedTolerance{.yaw = 4}.validate(); }),
              HasSubstr("tolerance.yaw: 4"));
}

}  // namespace
}  // namespace pipescout::rack_vision
