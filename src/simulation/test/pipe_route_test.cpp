// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/pipe_route.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "pipescout/simulation/motion.hpp"
#include "strapdown.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kEase = 0.6;

std::vector<RoutePiece> crooked() {
  return {RoutePiece::straight(5),         RoutePiece::bend(1.5, kPi / 2), RoutePiece::straight(3),
          RoutePiece::slope_bend(2, 0.5),  RoutePiece::straight(4),        RoutePiece::bend(3, -1),
          RoutePiece::slope_bend(2, -0.8), RoutePiece::straight(5)};
}

TEST(PipeRoute, AStraightIsStraight) {
  const std::vector<RoutePiece> pieces{RoutePiece::straight(10)};
  const PipeRoute route(pieces, 0.5, {1, 2, 3}, kPi / 6);
  const Vector3d along(std::cos(kPi / 6), std::sin(kPi / 6), 0);
  EXPECT_DOUBLE_EQ(route.length(), 10);
  for (const double s : {-4.0, 0.0, 3.3, 10.0, 17.0}) {
    EXPECT_LT((route.position(s) - Vector3d(1, 2, 3) - s * along).norm(), 1e-12);
  }
  const BodyMotion motion = route.motion(4, 0.7, 0.2);
  EXPECT_LT((motion.velocity - 0.7 * along).norm(), 1e-14);
  EXPECT_LT((motion.specific_force() - Vector3d(0.2, 0, kGravity)).norm(), 1e-13);
  EXPECT_EQ(motion.angular_rate, Vector3d::Zero());
}

TEST(PipeRoute, ABendIsAnArcOfItsRadius) {
  // All of it is within one piece: no easing at its ends.
  const std::vector<RoutePiece> pieces{RoutePiece::bend(2, kPi)};
  const PipeRoute route(pieces, 0.01);
  for (const double angle : {0.1, 1.0, 2.0, 3.0}) {
    const Vector3d expected(2 * std::sin(angle), 2 - 2 * std::cos(angle), 0);
    EXPECT_LT((route.position(2 * angle) - expected).norm(), 1e-9);
  }
  const BodyMotion motion = route.motion(2, 0.5, 0);
  EXPECT_LT((motion.angular_rate - Vector3d(0, 0, 0.25)).norm(), 1e-14);
  EXPECT_LT((motion.specific_force() - Vector3d(0, 0.125, kGravity)).norm(), 1e-13);
}

TEST(PipeRoute, OnASlopeGravityPullsBack) {
  const std::vector<RoutePiece> pieces{RoutePiece::slope_bend(2, 0.3), RoutePiece::straight(5)};
  const PipeRoute route(pieces, kEase);
  const BodyMotion motion = route.motion(4, 0.4, 0);
  EXPECT_NEAR(motion.velocity.z(), 0.4 * std::sin(0.3), 1e-12);
  EXPECT_LT((motion.specific_force() - kGravity * Vector3d(std::sin(0.3), 0, std::cos(0.3))).norm(),
            1e-12);
}

TEST(PipeRoute, AnglesAreThoseOfThePieces) {
  const auto pieces = crooked();
  const PipeRoute route(pieces, kEase);
  const Vector3d angles = route.motion(route.length(), 1, 0).T_map_body.rotation().roll_pitch_yaw();
  EXPECT_NEAR(angles.x(), 0, 1e-12);
  EXPECT_NEAR(angles.y(), -(0.5 - 0.8), 1e-12);
  EXPECT_NEAR(angles.z(), kPi / 2 - 1, 1e-12);
}

TEST(PipeRoute, RatesAndAccelerationsAreDerivatives) {
  const auto pieces = crooked();
  const PipeRoute route(pieces, kEase);
  constexpr double kSpeed = 0.6;
  constexpr double kAcceleration = -0.3;
  constexpr double kDt = 1e-4;
  const auto at = [&](double s, double t) {
    return route.motion(s + kSpeed * t + kAcceleration * t * t / 2, kSpeed + kAcceleration * t,
                        kAcceleration);
  };
  for (double s = 0.53; s < route.length(); s += 0.37) {
    const BodyMotion before = at(s, -kDt);
    const BodyMotion now = at(s, 0);
    const BodyMotion after = at(s, kDt);
    const Vector3d moved = after.T_map_body.translation() - before.T_map_body.translation();
    const geometry::SO3 turned =
        before.T_map_body.rotation().inverse() * after.T_map_body.rotation();
    EXPECT_LT((moved / (2 * kDt) - now.velocity).norm(), 1e-6) << s;
    EXPECT_LT(((after.velocity - before.velocity) / (2 * kDt) - now.acceleration).norm(), 1e-5);
    EXPECT_LT((turned.log() / (2 * kDt) - now.angular_rate).norm(), 1e-6) << s;
    EXPECT_LT(
        ((after.angular_rate - before.angular_rate) / (2 * kDt) - now.angular_acceleration).norm(),
        1e-3)  // jumps where the rates begin to change
        << s;
  }
}

TEST(PipeRoute, APerfectImuGivesTheTruthBack) {
  const auto pieces = crooked();
  const PipeRoute route(pieces, kEase);
  const Motion drive({{.speed = 0.5, .duration = 30},
                      {.speed = 0, .duration = 5},
                      {.speed = -0.3, .duration = 10},
                      {.speed = 0.6, .duration = 20}},
                     0.25);
  const geometry::SE3 T_body_imu(geometry::SO3::about_x(0.1), {0.1, 0.05, 0.2});
  constexpr double kStep = 0.002;
  const auto at = [&](double t) {
    return route
        .motion(drive.distance(t), drive.speed(t), drive.pieces()[drive.piece_at(t)].acceleration)
        .of(T_body_imu);
  };
  test::Strapdown navigator(at(0));
  const int steps = static_cast<int>(drive.duration() / kStep);
  for (int i = 1; i <= steps; ++i) {
    navigator.advance(at(i * kStep), kStep);
  }
  EXPECT_LT(navigator.position_error(), 0.05);  // accelerations jump between samples
  EXPECT_LT(navigator.velocity_error(), 0.002);
  EXPECT_LT(navigator.attitude_error(), 1e-5);
}

TEST(PipeRoute, ItsPolylineIsOnIt) {
  const auto pieces = crooked();
  const PipeRoute route(pieces, kEase);
  const auto points = route.polyline(0.25);
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double step = (points[i] - points[i - 1]).norm();
    EXPECT_LE(step, 0.25);
    length += step;
  }
  EXPECT_NEAR(length, route.length(), 0.01);  // chords
  EXPECT_EQ(points.back(), route.position(route.length()));
}

TEST(PipeRoute, FollowsAJointedPipe) {
  const JointedPipe pipe({.joints = 40, .bend_share = 0.3, .slope_share = 0.3}, 3);
  const PipeRoute route(route_pieces(pipe), 0.8);
  EXPECT_NEAR(route.length(), pipe.length(), 1e-9);
  for (const Joint& joint : pipe.joints()) {
    const double middle = joint.begin + joint.length / 2;
    const Vector3d angles = route.motion(middle, 1, 0).T_map_body.rotation().roll_pitch_yaw();
    EXPECT_NEAR(std::remainder(angles.z() - pipe.heading(middle), 2 * kPi), 0, 1e-9);
    EXPECT_NEAR(angles.y(), -pipe.pitch(middle), 1e-9);
  }
}

TEST(PipeRoute, RefusesNonsense) {
  const std::vector<RoutePiece> short_one{RoutePiece::straight(0.3)};
  EXPECT_THROW(PipeRoute({}, 0.5), std::invalid_argument);
  EXPECT_THROW(PipeRoute(short_one, 0.5), std::invalid_argument);
  EXPECT_THROW(PipeRoute(short_one, 0), std::invalid_argument);
  EXPECT_THROW(PipeRoute(short_one, 0.1, {NAN, 0, 0}), std::invalid_argument);
  EXPECT_THROW((void)PipeRoute(short_one, 0.1).polyline(0), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
