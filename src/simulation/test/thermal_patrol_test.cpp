// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/thermal_patrol.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

namespace pipescout::simulation {
namespace {

ThermalPatrolParameters patrol_of(std::uint64_t seed) {
  ThermalPatrolParameters parameters;
  parameters.scene.length = 60;
  parameters.end = 75;
  parameters.scene.T_map_row = {geometry::SO3::about_z(2), {30, -20, 0}};
  parameters.terrain.roughness = iso_8608_density(RoadClass::kD);
  parameters.seed = seed;
  return parameters;
}

TEST(ThermalPatrol, PassesTheRowAtSpeedWithTheTubeInView) {
  ThermalPatrol patrol(patrol_of(4));
  ThermalTruth truth;
  int frames = 0;
  double least_speed = 100;
  for (int i = 0; !patrol.arrived() && patrol.place() < 60; ++i) {
    patrol.drive_until(i * 0.04);
    if (patrol.place() < 0) {
      continue;
    }
    patrol.renderer().truth(patrol.view(0), truth);
    ASSERT_TRUE(truth.tube);
    EXPECT_GT(truth.tube->to_place - truth.tube->from_place, 1.5);
    EXPECT_LT(std::abs(std::remainder(std::atan2(truth.tube->to.y() - truth.tube->from.y(),
                                                 truth.tube->to.x() - truth.tube->from.x()),
                                      std::numbers::pi)),
              0.1);
    least_speed = std::min(least_speed, patrol.robot().speed());
    ++frames;
  }
  // 60 m at 5.5 m/s.
  EXPECT_NEAR(frames, 273, 5);
  EXPECT_GT(least_speed, 5.3);
}

TEST(ThermalPatrol, SeesTheNearestOfSeveralRowsAndNoTubeFromBehind) {
  ThermalPatrolParameters parameters = patrol_of(1);
  parameters.scene.T_map_row = {geometry::SO3(), {0, 20, 0}};
  ThermalSceneParameters behind = parameters.scene;
  behind.T_map_row = {geometry::SO3(), {0, 30, 0}};
  ThermalSceneParameters opposite = parameters.scene;
  opposite.T_map_row = {geometry::SO3::about_z(std::numbers::pi), {60, 0, 0}};
  parameters.further_rows = {behind, opposite};
  parameters.terrain.roughness = 0;
  // Of pose and row that is seen.
  for (const auto& [start, row] :
       {std::pair{Eigen::Vector3d(20, 10, 0), std::size_t{0}},
        std::pair{Eigen::Vector3d(20, 10, std::numbers::pi), std::size_t{2}},
        std::pair{Eigen::Vector3d(20, 25, 0), std::size_t{1}}}) {
    parameters.start = start;
    const ThermalPatrol patrol(parameters);
    EXPECT_EQ(patrol.robot().yaw(), start.z());
    EXPECT_EQ(patrol.row_in_view(), row);
    EXPECT_TRUE(patrol.rows()[row].faces(patrol.view(0).T_map_camera.translation()));
  }
  parameters.start = Eigen::Vector3d(20, 25, std::numbers::pi);
  ThermalPatrol patrol(parameters);
  EXPECT_EQ(patrol.row_in_view(), 0U);
  ThermalTruth truth;
  patrol.renderer().truth(patrol.view(0), truth);
  EXPECT_FALSE(truth.tube);
  // Nothing is as hot as the tube.
  std::vector<std::uint16_t> counts(320U * 240U);
  patrol.render(0, counts);
  const auto tube = static_cast<std::uint16_t>(patrol.renderer().counts(140));
  EXPECT_LT(std::ranges::count_if(counts, [&](std::uint16_t count) { return count > tube; }), 100);
}

TEST(GroundRobot, TheOriginMayBeOnTheRearAxle) {
  GroundRobotParameters parameters;
  parameters.wheels_ahead = parameters.wheel_base / 2;
  TerrainParameters slope;
  slope.roughness = 0;
  slope.slope = {0.1, 0};
  const GroundRobot robot(parameters, Terrain(slope, 1), {3, 0}, 0, 1);
  // On a plane: as high above it, and as tilted, wherever the wheels are.
  EXPECT_NEAR(robot.motion().T_map_body.translation().z(), 0.3 + parameters.ride_height, 1e-9);
  EXPECT_NEAR(robot.motion().T_map_body.rotation().roll_pitch_yaw().y(), -std::atan(0.1), 1e-9);
}

TEST(ThermalPatrol, TellsHowItsCameraMoves) {
  ThermalPatrol patrol(patrol_of(1));
  patrol.drive_until(6);
  const geometry::SE3 before = patrol.view(0).T_map_camera;
  patrol.step();
  const geometry::Vector6d velocity = patrol.view(0).velocity;
  patrol.step();
  const geometry::Vector6d moved =
      (before.inverse() * patrol.view(0).T_map_camera).log() / (2 * GroundRobot::kStep);
  EXPECT_GT(velocity.head<3>().norm(), 5);
  EXPECT_LT((moved - velocity).norm(), 0.05);
}

TEST(ThermalPatrol, IsTheSameForTheSameSeedHoweverItIsDriven) {
  ThermalPatrol at_once(patrol_of(2));
  ThermalPatrol in_pieces(patrol_of(2));
  ThermalPatrol other(patrol_of(3));
  at_once.drive_until(4);
  for (double time = 0; time < 4; time += 0.033) {
    in_pieces.drive_until(time);
  }
  in_pieces.drive_until(4);
  in_pieces.drive_until(1);
  other.drive_until(4);
  EXPECT_EQ(at_once.view(0).T_map_camera.matrix(), in_pieces.view(0).T_map_camera.matrix());
  EXPECT_NE(at_once.view(0).T_map_camera.matrix(), other.view(0).T_map_camera.matrix());
  std::vector<std::uint16_t> first(320 * 240);
  std::vector<std::uint16_t> second(320 * 240);
  at_once.render(9, first);
  in_pieces.render(9, second);
  EXPECT_EQ(first, second);
}

TEST(ThermalPatrol, StandsWhenItIsToldTo) {
  ThermalPatrol patrol(patrol_of(1));
  const double begin = patrol.place();
  for (int i = 0; i < 500; ++i) {
    patrol.stand();
  }
  EXPECT_NEAR(patrol.place(), begin, 0.01);
  patrol.drive_until(3);
  EXPECT_GT(patrol.place(), begin + 1);
}

TEST(ThermalPatrol, RefusesWhatIsOutOfRange) {
  ThermalPatrolParameters parameters = patrol_of(1);
  parameters.end = parameters.begin;
  EXPECT_THROW(ThermalPatrol{parameters}, std::invalid_argument);
  parameters = patrol_of(1);
  parameters.speed = 0;
  EXPECT_THROW(ThermalPatrol{parameters}, std::invalid_argument);
  parameters = patrol_of(1);
  parameters.scene.tube_radius = 0;
  EXPECT_THROW(ThermalPatrol{parameters}, std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
