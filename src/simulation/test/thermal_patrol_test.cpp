// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/thermal_patrol.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
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
