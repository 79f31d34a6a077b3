// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/visual_servo.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/rack_vision/way_point_mission.hpp"

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = std::numbers::pi;

/// Pose of the default camera on a vehicle there.
CameraPose camera_pose(double time, const SE3& T_rack_base) {
  const SE3 T_rack_camera = T_rack_base * downward_camera();
  return {.time = time,
          .position = T_rack_camera.translation(),
          .orientation = T_rack_camera.rotation().quaternion()};
}

CameraPose camera_pose(double time, const Vector3d& position,
                       const Vector3d& roll_pitch_yaw = Vector3d::Zero()) {
  return camera_pose(time, SE3(SO3::from_roll_pitch_yaw(roll_pitch_yaw), position));
}

PathPoint stand_at(const Vector3d& position, double yaw = 0) {
  return {.position = position, .yaw = yaw};
}

/// The command once the limits of the acceleration are out of the way.
ServoCommand settled(VisualServo& servo, const CameraPose& pose, const PathPoint& target) {
  ServoCommand command;
  for (int i = 0; i < 100; ++i) {
    const double now = pose.time + 0.04 * i;
    CameraPose again = pose;
    again.time = now;
    EXPECT_EQ(servo.observe(again, now), PoseVerdict::kTaken);
    command = servo.step(now, target);
  }
  return command;
}

TEST(DownwardCamera, LooksDownWithTheImageForward) {
  const SE3 T_base_camera = downward_camera({0.1, 0, -0.05});
  EXPECT_LT((T_base_camera.rotation() * Vector3d(0, 0, 1) - Vector3d(0, 0, -1)).norm(), 1e-12);
  // Up in the image is -y, right is x.
  EXPECT_LT((T_base_camera.rotation() * Vector3d(0, -1, 0) - Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((T_base_camera.rotation() * Vector3d(1, 0, 0) - Vector3d(0, -1, 0)).norm(), 1e-12);
  EXPECT_LT((T_base_camera * Vector3d(0, 0, 1) - Vector3d(0.1, 0, -1.05)).norm(), 1e-12);
}

TEST(PoseError, BringsTheOneFrameToTheOther) {
  const SE3 T_rack_base(SO3::from_roll_pitch_yaw({0.1, -0.2, 2}), {1, 2, 3});
  const SE3 T_rack_target(SO3::from_roll_pitch_yaw({-0.3, 0.1, -2.5}), {2, 1, 4});
  const SE3 reached = T_rack_base * SE3::exp(pose_error(T_rack_base, T_rack_target));
  EXPECT_LT((reached.matrix() - T_rack_target.matrix()).norm(), 1e-12);
  EXPECT_LT(pose_error(T_rack_base, T_rack_base).norm(), 1e-12);
}

TEST(Level, KeepsPlaceAndHeading) {
  const SE3 tilted(SO3::from_roll_pitch_yaw({0.3, -0.4, 2}), {1, 2, 3});
  const std::optional<SE3> levelled = level(tilted);
  ASSERT_TRUE(levelled);
  EXPECT_LT((levelled->rotation().roll_pitch_yaw() - Vector3d(0, 0, 2)).norm(), 1e-12);
  EXPECT_EQ(levelled->translation(), tilted.translation());
  EXPECT_FALSE(level(SE3(SO3::about_y(kPi / 2), {0, 0, 0})));
}

TEST(VisualServo, CommandsTheGainTimesTheErrorInTheHeadingFrame) {
  VisualServo servo({.position_gain = 2});
  // 0.1 m to the north of a vehicle that heads north, then one that heads west: ahead, right.
  const PathPoint target = stand_at({1, 5.1, 3}, kPi / 2);
  const ServoCommand ahead = settled(servo, camera_pose(1, {1, 5, 3}, {0, 0, kPi / 2}), target);
  EXPECT_EQ(ahead.state, ServoState::kServoing);
  EXPECT_LT((ahead.linear - Vector3d(0.2, 0, 0)).norm(), 1e-9);
  EXPECT_LT(ahead.angular.norm(), 1e-9);
  EXPECT_NEAR(ahead.position_error, 0.1, 1e-9);
  EXPECT_NEAR(ahead.rotation_error, 0, 1e-9);

  VisualServo other({.position_gain = 2});
  const ServoCommand right =
      settled(other, camera_pose(1, {1, 5, 3}, {0, 0, kPi}), stand_at({1, 5.1, 3}, kPi));
  EXPECT_LT((right.linear - Vector3d(0, -0.2, 0)).norm(), 1e-9);
}

TEST(VisualServo, TurnsTheShortWayAndOnlyAboutTheVertical) {
  VisualServo servo({.rotation_gain = 1});
  const ServoCommand command =
      settled(servo, camera_pose(1, {1, 5, 3}, {0.2, -0.1, 3.1}), stand_at({1, 5, 3}, -3.1));
  // No way to go, so that the tilt of the vehicle must not show in the velocity.
  EXPECT_LT(command.linear.norm(), 1e-9);
  EXPECT_EQ(command.angular.head<2>().norm(), 0);
  EXPECT_NEAR(command.angular.z(), 2 * kPi - 6.2, 1e-9);
  EXPECT_NEAR(command.rotation_error, 2 * kPi - 6.2, 1e-9);
}

TEST(VisualServo, FullRotationIsTheLogarithmOfTheError) {
  VisualServo servo({.rotation = RotationControl::kFull,
                     .position_gain = 1,
                     .rotation_gain = 1,
                     .largest_speed = 10,
                     .largest_rotation_rate = 6});
  const SE3 T_rack_base(SO3::from_roll_pitch_yaw({0.2, -0.1, 0.5}), {1, 5, 3});
  const SE3 T_rack_target(SO3::about_z(0.7), {1.1, 5.2, 2.9});
  const ServoCommand command =
      settled(servo, camera_pose(1, T_rack_base), stand_at({1.1, 5.2, 2.9}, 0.7));
  const geometry::Vector6d expected = pose_error(T_rack_base, T_rack_target);
  EXPECT_LT((command.linear - expected.head<3>()).norm(), 1e-9);
  EXPECT_LT((command.angular - expected.tail<3>()).norm(), 1e-9);
}

TEST(VisualServo, SaturatesTheNormAndKeepsTheDirection) {
  VisualServo servo({});
  const ServoCommand command = settled(servo, camera_pose(1, {0, 0, 3}), stand_at({6, -8, 3}));
  EXPECT_LT((command.linear - Vector3d(0.3, -0.4, 0)).norm(), 1e-9);
  VisualServo turning({});
  EXPECT_NEAR(settled(turning, camera_pose(1, {0, 0, 3}), stand_at({0, 0, 3}, -2)).angular.z(),
              -0.2, 1e-12);
}

TEST(VisualServo, LimitsTheAcceleration) {
  VisualServo servo({});
  double now = 1;
  Vector3d before = Vector3d::Zero();
  double turn_before = 0;
  for (int i = 0; i < 200; ++i, now += 0.04) {
    servo.observe(camera_pose(now, {0, 0, 3}), now);
    const double way = i < 60 ? 5 : -5;
    const ServoCommand command = servo.step(now, stand_at({way, way / 2, 3}, way));
    EXPECT_LE((command.linear - before).norm(), 1.0 * 0.04 + 1e-9) << i;
    EXPECT_LE(std::abs(command.angular.z() - turn_before), 1.0 * 0.04 + 1e-9) << i;
    EXPECT_LE(command.linear.norm(), 0.5 + 1e-9);
    before = command.linear;
    turn_before = command.angular.z();
  }
  EXPECT_NEAR(before.norm(), 0.5, 1e-9);
}

TEST(VisualServo, AddsTheVelocityOfTheTarget) {
  VisualServo servo({});
  PathPoint target = stand_at({1, 5, 3}, kPi / 2);
  target.velocity = {0, 0.3, 0};
  target.acceleration = {0, 0.1, 0};
  target.yaw_rate = 0.1;
  const ServoCommand command = settled(servo, camera_pose(1, {1, 5, 3}, {0, 0, kPi / 2}), target);
  // Ahead by the response time of 0.2 s.
  EXPECT_LT((command.linear - Vector3d(0.32, 0, 0)).norm(), 1e-9);
  EXPECT_NEAR(command.angular.z(), 0.1, 1e-9);
}

TEST(VisualServo, KnowsWhereTheCameraSitsOnTheVehicle) {
  const SE3 T_base_camera = downward_camera({0.2, 0, -0.1});
  VisualServo servo({.T_base_camera = T_base_camera});
  const SE3 T_rack_base(SO3::about_z(1), {1, 5, 3});
  const SE3 T_rack_camera = T_rack_base * T_base_camera;
  servo.observe({.time = 1,
                 .position = T_rack_camera.translation(),
                 .orientation = T_rack_camera.rotation().quaternion()},
                1);
  ASSERT_TRUE(servo.T_rack_base(1));
  EXPECT_LT((servo.T_rack_base(1)->matrix() - T_rack_base.matrix()).norm(), 1e-12);
  EXPECT_EQ(servo.pose_time(), 1);
}

TEST(VisualServo, TakesThePoseOfACameraThatMovesOnTheVehicle) {
  VisualServo servo({.T_base_camera = downward_camera({0.2, 0, -0.1})});
  const SE3 T_base_camera = SE3(SO3::about_z(0.3), {0.1, 0, -0.2}) * downward_camera();
  servo.set_T_base_camera(T_base_camera);
  const SE3 T_rack_base(SO3::about_z(1), {1, 5, 3});
  const SE3 T_rack_camera = T_rack_base * T_base_camera;
  servo.observe({.time = 1,
                 .position = T_rack_camera.translation(),
                 .orientation = T_rack_camera.rotation().quaternion()},
                1);
  ASSERT_TRUE(servo.T_rack_base(1));
  EXPECT_LT((servo.T_rack_base(1)->matrix() - T_rack_base.matrix()).norm(), 1e-12);
}

TEST(VisualServo, BringsAVehicleAlongAPathAndToItsWayPoints) {
  const std::vector<WayPoint> points{
      {{0.7, 5, 3}, 0, 2}, {{1.7, 6, 3}, 0.2, 2}, {{1.7, 4, 2.5}, -0.2, 2}, {{0.7, 5, 3}, 3, 2}};
  WayPointMission mission(WayPointPath(points, {}), {});
  VisualServo servo({.response_time = 0});
  SE3 T_rack_base(SO3::about_z(0.5), {1, 4.5, 2.8});
  double now = 10;
  double farthest = 0;
  for (; !mission.complete() && now < 200; now += 0.04) {
    servo.observe(camera_pose(now, T_rack_base), now);
    mission.advance(now, LevelPose{.time = now,
                                   .position = T_rack_base.translation(),
                                   .yaw = T_rack_base.rotation().roll_pitch_yaw().z()});
    const PathPoint target = mission.target(now);
    const ServoCommand command = servo.step(now, target);
    if (!mission.waiting() && mission.current() > 0) {
      farthest = std::max(farthest, (T_rack_base.translation() - target.position).norm());
    }
    geometry::Vector6d motion;
    motion << command.linear * 0.04, command.angular * 0.04;
    T_rack_base = T_rack_base * SE3::exp(motion);
  }
  EXPECT_EQ(mission.count(WayPointOutcome::kReached), 4U);
  EXPECT_LT(farthest, 0.01);
}

TEST(VisualServo, HoldsWhenThePoseIsStaleThenClimbsThenHolds) {
  VisualServo servo({});
  const PathPoint target = stand_at({5, 5, 3});
  ServoCommand command = settled(servo, camera_pose(1, {0, 5, 3}), target);
  EXPECT_GT(command.linear.norm(), 0.49);
  double now = 1 + 99 * 0.04;
  double climbed = 0;
  double holding_since = 0;
  double climbing_since = 0;
  bool held_again = false;
  for (; now < 30; now += 0.04) {
    command = servo.step(now, target);
    climbed += command.linear.z() * 0.04;
    if (command.state == ServoState::kHolding && holding_since == 0) {
      holding_since = now;
    }
    if (command.state == ServoState::kClimbing) {
      climbing_since = climbing_since == 0 ? now : climbing_since;
      EXPECT_EQ(command.linear.head<2>().norm(), 0);
    }
    held_again = held_again || (climbing_since > 0 && command.state == ServoState::kHolding);
  }
  EXPECT_NEAR(holding_since, 1 + 99 * 0.04 + 0.5, 0.05);
  EXPECT_NEAR(climbing_since - holding_since, 3, 0.05);
  EXPECT_TRUE(held_again);
  EXPECT_EQ(command.linear.norm(), 0);
  // Beyond the height by the way that it takes to stop: 0.3^2 / 2 m.
  EXPECT_NEAR(climbed, 2.05, 0.03);

  // A pose again: on with the flight, and a later loss holds anew.
  servo.observe(camera_pose(now, {0, 5, 5}), now);
  EXPECT_EQ(servo.step(now, target).state, ServoState::kServoing);
  EXPECT_EQ(servo.step(now + 0.6, target).state, ServoState::kHolding);
}

TEST(VisualServo, HoldsBeforeItsFirstPose) {
  VisualServo servo({.hold_time = 1});
  for (double now = 0; now < 60; now += 0.1) {
    const ServoCommand command = servo.step(now, stand_at({1, 1, 1}));
    EXPECT_EQ(command.state, ServoState::kHolding);
    EXPECT_EQ(command.linear.norm() + command.angular.norm(), 0);
  }
}

TEST(VisualServo, HoldsForEverWithoutAClimbSpeed) {
  VisualServo servo({.hold_time = 1, .climb_speed = 0});
  const PathPoint target = stand_at({5, 5, 3});
  settled(servo, camera_pose(1, {0, 5, 3}), target);
  ServoCommand command;
  for (double now = 1 + 99 * 0.04 + 0.6; now < 20; now += 0.1) {
    command = servo.step(now, target);
    EXPECT_EQ(command.state, ServoState::kHolding);
    EXPECT_EQ(command.linear.z(), 0);
  }
  EXPECT_EQ(command.linear.norm(), 0);
}

TEST(VisualServo, StandsWithoutATarget) {
  VisualServo servo({});
  settled(servo, camera_pose(1, {0, 5, 3}), stand_at({5, 5, 3}));
  double now = 1 + 99 * 0.04;
  ServoCommand command;
  for (int i = 0; i < 20; ++i) {
    command = servo.step(now += 0.04, std::nullopt);
    EXPECT_EQ(command.state, ServoState::kIdle);
  }
  EXPECT_EQ(command.linear.norm(), 0);
  for (; now < 20; now += 0.04) {
    command = servo.step(now, std::nullopt);
  }
  EXPECT_EQ(command.linear.norm(), 0);
}

TEST(VisualServo, SaysWhyItDoesNotTakeAPose) {
  VisualServo servo({});
  const CameraPose good = camera_pose(10, {1, 5, 3});
  EXPECT_EQ(servo.observe(good, 10.1), PoseVerdict::kTaken);

  CameraPose bad = good;
  bad.position.z() = kNaN;
  EXPECT_EQ(servo.observe(bad, 10), PoseVerdict::kNotANumber);
  bad = good;
  bad.orientation.w() = std::numeric_limits<double>::infinity();
  EXPECT_EQ(servo.observe(bad, 10), PoseVerdict::kNotANumber);
  bad = good;
  bad.time = kNaN;
  EXPECT_EQ(servo.observe(bad, 10), PoseVerdict::kNotANumber);
  bad = good;
  bad.quality = kNaN;
  EXPECT_EQ(servo.observe(bad, 10), PoseVerdict::kNotANumber);
  EXPECT_EQ(servo.observe(good, kNaN), PoseVerdict::kNotANumber);
  bad = good;
  bad.orientation.coeffs() *= 1.01;
  EXPECT_EQ(servo.observe(bad, 10), PoseVerdict::kNoRotation);
  bad.orientation.coeffs().setZero();
  EXPECT_EQ(servo.observe(bad, 10), PoseVerdict::kNoRotation);
  bad = good;
  bad.time = 10.16;
  EXPECT_EQ(servo.observe(bad, 10.1), PoseVerdict::kFromTheFuture);
  bad.time = 10.14;
  EXPECT_EQ(servo.observe(bad, 10.1), PoseVerdict::kTaken);
  EXPECT_EQ(servo.observe(bad, 10.7), PoseVerdict::kStale);
  EXPECT_EQ(servo.observe(bad, 10.2), PoseVerdict::kOutOfOrder);
  bad.time = 10.2;
  bad.quality = 0.1;
  EXPECT_EQ(servo.observe(bad, 10.2), PoseVerdict::kLowQuality);

  EXPECT_THAT(servo.counts(), testing::ElementsAre(2, 5, 2, 1, 1, 1, 1));
  // Nothing of that moved it.
  EXPECT_EQ(servo.pose_time(), 10.14);
  for (int i = 0; i < 7; ++i) {
    EXPECT_STRNE(to_string(static_cast<PoseVerdict>(i)), "unknown");
  }
  EXPECT_STREQ(to_string(static_cast<PoseVerdict>(7)), "unknown");
  EXPECT_STREQ(to_string(ServoState::kClimbing), "climbing");
}

TEST(VisualServo, BeginsAgainWithTheClock) {
  VisualServo servo({});
  const PathPoint target = stand_at({5, 5, 3});
  const ServoCommand last = settled(servo, camera_pose(100, {0, 5, 3}), target);
  const double now = 100 + 99 * 0.04;
  // Small steps back and NaN: as before.
  EXPECT_EQ(servo.step(now - 0.5, target).linear, last.linear);
  EXPECT_EQ(servo.step(kNaN, target).linear, last.linear);
  // A simulation that begins again: its poses are taken.
  EXPECT_EQ(servo.step(1, target).state, ServoState::kHolding);
  EXPECT_EQ(servo.observe(camera_pose(1.04, {0, 5, 3}), 1.04), PoseVerdict::kTaken);
  EXPECT_EQ(servo.step(1.04, target).state, ServoState::kServoing);
}

TEST(VisualServo, RejectsParametersOutOfRange) {
  const auto message = [](const VisualServoParameters& parameters) -> std::string {
    try {
      const VisualServo servo(parameters);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({}), "");
  EXPECT_THAT(message({.position_gain = 0}), HasSubstr("position_gain: 0"));
  EXPECT_THAT(message({.rotation_gain = 21}), HasSubstr("rotation_gain: 21"));
  EXPECT_THAT(message({.response_time = -1}), HasSubstr("response_time: -1"));
  EXPECT_THAT(message({.largest_speed = kNaN}), HasSubstr("largest_speed"));
  EXPECT_THAT(message({.largest_rotation_rate = 0}), HasSubstr("largest_rotation_rate: 0"));
  EXPECT_THAT(message({.largest_acceleration = 0}), HasSubstr("largest_acceleration: 0"));
  EXPECT_THAT(message({.largest_rotation_acceleration = 51}),
              HasSubstr("largest_rotation_acceleration: 51"));
  EXPECT_THAT(message({.stale_after = 0}), HasSubstr("stale_after: 0"));
  EXPECT_THAT(message({.future_tolerance = 2}), HasSubstr("future_tolerance: 2"));
  EXPECT_THAT(message({.smallest_quality = 1.5}), HasSubstr("smallest_quality: 1.5"));
  EXPECT_THAT(message({.hold_time = -1}), HasSubstr("hold_time: -1"));
  EXPECT_THAT(message({.climb_speed = 0.6}), HasSubstr("climb_speed: 0.6"));
  EXPECT_THAT(message({.climb_height = -1}), HasSubstr("climb_height: -1"));
}

}  // namespace
}  // namespace pipescout::rack_vision
