// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/plant_yard.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "pipescout/simulation/ackermann_vehicle.hpp"

namespace pipescout::simulation {
namespace {

TEST(PlantYard, ChecksContactsAndClearances) {
  PlantYard yard({}, 1);
  yard.remove_movers();
  const YardBox in_aisle{
      .centre = {1, yard.aisle_middle(0)}, .half_length = 0.95, .half_width = 0.5};
  EXPECT_FALSE(yard.collides(in_aisle));
  EXPECT_NEAR(yard.clearance(in_aisle), yard.parameters().aisle / 2 - 0.5, 1e-9);
  EXPECT_TRUE(yard.collides({.centre = {10, 0}}));
  EXPECT_EQ(yard.clearance({.centre = {10, 0}}), 0);
  EXPECT_NEAR(box_distance({.centre = {0, 0}}, {.centre = {3, 0}}), 2, 1e-12);
  EXPECT_NEAR(box_distance({.centre = {0, 0}}, {.centre = {2, 0}, .heading = std::numbers::pi / 4}),
              1.5 - std::numbers::sqrt2 / 2, 1e-12);
}

TEST(PlantYard, ScansWhatStandsThere) {
  PlantYard yard({.unmapped = 0}, 1);
  yard.remove_movers();
  std::vector<float> ranges;
  const LidarParameters lidar{.beams = 4 * 90, .noise = 0, .dropouts = 0};
  yard.scan(lidar, {20, yard.aisle_middle(0)}, 0, 1, ranges);
  // Beams 90 and 270: to the right and to the left.
  EXPECT_NEAR(ranges.at(90), yard.parameters().aisle / 2, 1e-5);
  EXPECT_NEAR(ranges.at(270), yard.parameters().aisle / 2, 1e-5);
  EXPECT_TRUE(std::isinf(ranges.at(180)));
  EXPECT_THROW(yard.scan({.beams = 1}, {0, 0}, 0, 1, ranges), std::invalid_argument);
  EXPECT_THROW(yard.scan({.noise = -1}, {0, 0}, 0, 1, ranges), std::invalid_argument);
}

TEST(PlantYard, MoversHaltForTheRobot) {
  PlantYard yard({.people = 0, .vehicles = 0}, 1);
  const double y = yard.aisle_middle(0);
  yard.add_mover({.box = {.centre = {5, y}}, .from = {5, y}, .to = {30, y}, .speed = 1});
  const YardBox robot{.centre = {15, y}, .half_length = 0.95, .half_width = 0.5};
  for (int i = 0; i < 60'000; ++i) {
    yard.step(1e-3, robot);
    ASSERT_FALSE(yard.collides(robot));
  }
}

TEST(AckermannVehicle, TurnsOnTheCircleOfItsSteeringAndStopsForNonsense) {
  AckermannVehicle vehicle({.understeer = 0, .wheel_slip = 0}, {});
  vehicle.command(1, 0.3);
  for (int i = 0; i < 5000; ++i) {
    vehicle.step();
  }
  EXPECT_NEAR(vehicle.state().speed, 1, 1e-9);
  EXPECT_NEAR(vehicle.state().yaw_rate, std::tan(0.3) / 1.2, 1e-9);
  vehicle.command(std::nan(""), 0);
  for (int i = 0; i < 2000; ++i) {
    vehicle.step();
  }
  EXPECT_NEAR(vehicle.state().speed, 0, 1e-9);
}

TEST(AckermannVehicle, UndersteersAndSlipsDownhill) {
  const auto run = [](const AckermannVehicleParameters& parameters, double steering) {
    AckermannVehicle vehicle(parameters, {});
    vehicle.command(1.5, steering);
    for (int i = 0; i < 4000; ++i) {
      vehicle.step();
    }
    return vehicle.state();
  };
  EXPECT_LT(run({.understeer = 0.05}, 0.3).yaw_rate, run({.understeer = 0}, 0.3).yaw_rate);
  // Uphill is to the left: it slips to the right.
  EXPECT_LT(run({.slope = 0.1, .uphill = std::numbers::pi / 2}, 0).y, -0.1);
  EXPECT_THROW(AckermannVehicle({.wheel_base = 0}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
