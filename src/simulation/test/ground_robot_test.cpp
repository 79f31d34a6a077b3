// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/ground_robot.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "strapdown.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const TerrainParameters kFlat{.roughness = 0};

GroundRobotParameters ideal() {
  return {.side_slip = 0,
          .wheel_scale_error = 0,
          .wheel_noise = 0,
          .traction_slip = 0,
          .slip_spacing = 0,
          .wheel_resolution = 0};
}

void run(GroundRobot& robot, double duration) {
  const int steps = static_cast<int>(std::lround(duration / GroundRobot::kStep));
  for (int i = 0; i < steps; ++i) {
    robot.step();
  }
}

TEST(GroundRobot, ACircleOnAPlane) {
  GroundRobot robot(ideal(), Terrain(kFlat, 1), {0, 0}, 0, 1);
  robot.command({.speed = 3, .yaw_rate = 0.5});
  run(robot, 20);
  const BodyMotion& motion = robot.motion();
  const Vector3d centripetal(0, 3 * 0.5, kGravity);  // in the level frame
  const double roll = motion.T_map_body.rotation().roll_pitch_yaw().x();
  EXPECT_NEAR(roll, 0.006 * 1.5, 1e-6);  // it leans out of the turn, to the right
  EXPECT_LT((motion.specific_force() - geometry::SO3::about_x(-roll) * centripetal).norm(), 1e-5);
  EXPECT_LT((motion.angular_rate - geometry::SO3::about_x(-roll) * Vector3d(0, 0, 0.5)).norm(),
            1e-6);
  // Radius 6 m about a centre that stays.
  const auto centre = [&] {
    const auto& T = robot.motion().T_map_body;
    return Vector2d(T.translation().head<2>() +
                    6 * Vector2d(-std::sin(robot.yaw()), std::cos(robot.yaw())));
  };
  const Vector2d begin = centre();
  run(robot, 7);
  EXPECT_LT((centre() - begin).norm(), 1e-5);
  // The outer wheels run on circles that are larger by half the track.
  const auto before = robot.odometers();
  run(robot, 2);
  const auto after = robot.odometers();
  for (std::size_t i = 0; i < kWheels; ++i) {
    const double radius = i % 2 == 0 ? 6 - 0.35 : 6 + 0.35;
    EXPECT_NEAR(after[i] - before[i], radius * 0.5 * 2, 1e-6);
  }
}

TEST(GroundRobot, OnASlopeGravityIsThatOfThePlane) {
  const Vector2d slope(0.15, -0.1);
  const Terrain plane({.roughness = 0, .slope = slope}, 1);
  for (const double yaw : {0.0, 0.7, 2.5, -1.9}) {
    GroundRobot robot(ideal(), plane, {5, 5}, yaw, 1);
    robot.command({.speed = 2});
    run(robot, 10);
    const BodyMotion& motion = robot.motion();
    const geometry::SO3& R = motion.T_map_body.rotation();
    const Vector3d normal = Vector3d(-slope.x(), -slope.y(), 1).normalized();
    EXPECT_LT((R * Vector3d::UnitZ() - normal).norm(), 1e-6) << yaw;
    EXPECT_LT((motion.specific_force() - R.inverse() * Vector3d(0, 0, kGravity)).norm(), 1e-5);
    EXPECT_NEAR(motion.velocity.norm(), 2, 1e-6);
    EXPECT_NEAR(motion.velocity.dot(normal), 0, 1e-6);
    EXPECT_LT((R.inverse() * motion.velocity - Vector3d(2, 0, 0)).norm(), 1e-5);
    EXPECT_NEAR(robot.distance(), robot.odometers()[0], 1e-9);
  }
}

TEST(GroundRobot, StandsOnRoughGround) {
  GroundRobot robot(ideal(), Terrain({.roughness = 4096e-6}, 7), {3, 4}, 1, 1);
  const Vector3d begin = robot.motion().T_map_body.translation();
  run(robot, 3);
  EXPECT_LT((robot.motion().T_map_body.translation() - begin).norm(), 1e-9);
  EXPECT_NEAR(robot.motion().specific_force().norm(), kGravity, 1e-9);
  EXPECT_EQ(robot.odometers()[2], 0);
}

TEST(GroundRobot, SlidesDownAndOutwards) {
  GroundRobotParameters parameters = ideal();
  parameters.side_slip = 0.02;
  GroundRobot turning(parameters, Terrain(kFlat, 1), {0, 0}, 0, 1);
  turning.command({.speed = 3, .yaw_rate = 0.5});
  run(turning, 20);
  Vector3d level = geometry::SO3::about_z(-turning.yaw()) * turning.motion().velocity;
  const double roll = turning.motion().T_map_body.rotation().roll_pitch_yaw().x();
  EXPECT_NEAR(level.y(), -0.02 * (1.5 + kGravity * std::sin(roll)), 1e-6);  // to the right
  GroundRobot across(parameters, Terrain({.roughness = 0, .slope = {0, 0.2}}, 1), {0, 0}, 0, 1);
  across.command({.speed = 3});
  run(across, 20);
  level = across.motion().velocity;
  EXPECT_NEAR(level.y(), -0.02 * kGravity * std::sin(std::atan(0.2)), 1e-6);
}

TEST(GroundRobot, APerfectImuGivesTheTruthBack) {
  for (const RoadClass road : {RoadClass::kC, RoadClass::kE}) {
    GroundRobot robot({}, Terrain({.roughness = iso_8608_density(road), .hill_height = 3}, 11),
                      {0, 0}, 0.4, 2);
    CourseController course({.speed = 5.5}, {{60, 0}, {60, 60}, {0, 60}, {0, 0}});
    const geometry::SE3 T_body_imu(geometry::SO3::about_z(0.2), {0.2, -0.1, 0.3});
    test::Strapdown navigator(robot.motion().of(T_body_imu));
    double shaken = 0;
    for (int i = 0; i < 30'000; ++i) {  // 60 s
      robot.command(course.steer(robot));
      robot.step();
      navigator.advance(robot.motion().of(T_body_imu), GroundRobot::kStep);
      shaken = std::max(shaken, std::abs(robot.motion().specific_force().z() - kGravity));
    }
    EXPECT_GT(robot.distance(), 200);
    EXPECT_GT(shaken, road == RoadClass::kC ? 1 : 4);
    // 0.1 deg/sqrt(h) of a good gyro is 2e-4 rad in a minute.
    EXPECT_LT(navigator.attitude_error(), 2e-5);
    EXPECT_LT(navigator.velocity_error(), 0.01);
    EXPECT_LT(navigator.position_error(), 0.3);
  }
}

TEST(GroundRobot, RatesAreDerivatives) {
  GroundRobot robot({}, Terrain({.roughness = 1024e-6, .hill_height = 3}, 3), {0, 0}, 0, 2);
  robot.command({.speed = 4, .yaw_rate = 0.4});
  run(robot, 5);
  for (int i = 0; i < 200; ++i) {
    const BodyMotion before = robot.motion();
    robot.step();
    const BodyMotion after = robot.motion();
    // The mean of both ends is that of the step but for its square: 1e-3 of the largest change.
    const Vector3d moved =
        (after.T_map_body.translation() - before.T_map_body.translation()) / GroundRobot::kStep;
    const geometry::SO3 turned =
        before.T_map_body.rotation().inverse() * after.T_map_body.rotation();
    EXPECT_LT((moved - (before.velocity + after.velocity) / 2).norm(), 1e-3);
    EXPECT_LT(
        (turned.log() / GroundRobot::kStep - (before.angular_rate + after.angular_rate) / 2).norm(),
        1e-3);
    EXPECT_LT(((after.velocity - before.velocity) / GroundRobot::kStep -
               (before.acceleration + after.acceleration) / 2)
                  .norm(),
              0.3);  // the ground's slope is held for a step: accelerations jump
    EXPECT_LT(((after.angular_rate - before.angular_rate) / GroundRobot::kStep -
               (before.angular_acceleration + after.angular_acceleration) / 2)
                  .norm(),
              1.0);
  }
}

TEST(GroundRobot, WheelsAreWrongAsTheParametersSay) {
  GroundRobotParameters parameters = ideal();
  parameters.wheel_noise = 0.01;
  parameters.wheel_resolution = 0.002;
  double square = 0;
  constexpr int kRuns = 100;
  for (int i = 0; i < kRuns; ++i) {
    GroundRobot robot(parameters, Terrain(kFlat, 1), {0, 0}, 0, static_cast<std::uint64_t>(i));
    robot.command({.speed = 5});
    run(robot, 5);
    for (const double shown : robot.odometers()) {
      EXPECT_NEAR(std::remainder(shown, 0.002), 0, 1e-9);
      square += std::pow(shown - robot.distance(), 2) / robot.distance() / (kRuns * kWheels);
    }
  }
  // Chi-square with 400 degrees of freedom; the counter adds less than 1 %.
  EXPECT_NEAR(square, 1e-4, 1e-4 * 4 * std::sqrt(2.0 / (kRuns * kWheels)));

  parameters = ideal();
  parameters.traction_slip = 0.01;
  GroundRobot climbing(parameters, Terrain({.roughness = 0, .slope = {0.2, 0}}, 1), {0, 0}, 0, 1);
  climbing.command({.speed = 2});
  run(climbing, 10);
  const double before = climbing.odometers()[1] - climbing.distance();
  run(climbing, 5);
  EXPECT_NEAR(climbing.odometers()[1] - climbing.distance() - before,
              0.01 * kGravity * std::sin(std::atan(0.2)) * 10, 1e-4);

  parameters = ideal();
  parameters.slip_spacing = 10;
  GroundRobot slipping(parameters, Terrain(kFlat, 1), {0, 0}, 0, 5);
  slipping.command({.speed = 5});
  run(slipping, 60);
  for (const double shown : slipping.odometers()) {
    // One of 1.75 m at 15 % each 11.75 m on average.
    EXPECT_GT(shown / slipping.distance(), 1.01);
    EXPECT_LT(shown / slipping.distance(), 1.04);
  }
}

TEST(GroundRobot, TheSameSeedGivesTheSameBits) {
  const auto drive = [](std::uint64_t seed) {
    GroundRobot robot({}, Terrain({}, seed), {0, 0}, 0, seed);
    CourseController course({}, {{20, 10}});
    for (int i = 0; i < 2000; ++i) {
      robot.command(course.steer(robot));
      robot.step();
    }
    return std::make_pair(robot.motion().T_map_body.matrix(), robot.odometers());
  };
  EXPECT_EQ(drive(3), drive(3));
  EXPECT_NE(drive(3), drive(4));
}

TEST(GroundRobot, IgnoresCommandsThatAreNone) {
  GroundRobot robot(ideal(), Terrain(kFlat, 1), {0, 0}, 0, 1);
  robot.command({.speed = 1});
  robot.command({.speed = NAN});
  robot.command({.speed = 1, .yaw_rate = INFINITY});
  run(robot, 10);
  EXPECT_EQ(robot.bad_commands(), 2U);
  EXPECT_NEAR(robot.speed(), 1, 1e-6);
  robot.command({.speed = 100});
  run(robot, 20);
  EXPECT_NEAR(robot.speed(), 5.56, 1e-6);
}

TEST(CourseController, PassesItsWayPointsAndStops) {
  GroundRobot robot({}, Terrain({.roughness = 1024e-6, .hill_height = 2}, 2), {0, 0}, 1, 1);
  const std::vector<Vector2d> way_points{{40, 0}, {40, 30}, {-10, 30}, {0, 0}};
  CourseController course({.speed = 5.5}, way_points);
  std::vector<double> nearest(way_points.size(), 1e9);
  for (int i = 0; i < 60'000 && !(course.arrived() && std::abs(robot.speed()) < 1e-3); ++i) {
    robot.command(course.steer(robot));
    robot.step();
    const Vector2d place = robot.motion().T_map_body.translation().head<2>();
    for (std::size_t k = 0; k < way_points.size(); ++k) {
      nearest[k] = std::min(nearest[k], (place - way_points[k]).norm());
    }
  }
  EXPECT_TRUE(course.arrived());
  EXPECT_LT(std::abs(robot.speed()), 1e-3);
  for (const double distance : nearest) {
    EXPECT_LT(distance, 2.5);
  }
}

TEST(GroundRobot, RefusesNonsense) {
  const Terrain flat(kFlat, 1);
  EXPECT_THROW(GroundRobot({.wheel_base = 0}, flat, {0, 0}, 0, 1), std::invalid_argument);
  EXPECT_THROW(GroundRobot({.slip_shortest = 2, .slip_longest = 1}, flat, {0, 0}, 0, 1),
               std::invalid_argument);
  EXPECT_THROW(GroundRobot({}, flat, {NAN, 0}, 0, 1), std::invalid_argument);
  EXPECT_THROW(CourseController({.slowest = 10}, {{0, 0}}), std::invalid_argument);
  EXPECT_THROW(CourseController({}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
