// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_world/plant_drive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace pipescout::simulation {
namespace {

PlantDriveParameters empty_plant() {
  PlantDriveParameters parameters;
  parameters.yard.people = 0;
  parameters.yard.vehicles = 0;
  parameters.yard.unmapped = 0;
  return parameters;
}

TEST(PlantDrive, DoesWhatATwistSaysAndStopsWithoutOne) {
  PlantDrive drive(empty_plant());
  // A creeping twist turns the wheels and does not move the vehicle.
  for (int i = 0; i < 20; ++i) {
    drive.command(0.001, 0.0003);
    drive.drive(50);
  }
  EXPECT_NEAR(drive.drive(0).steering, std::atan(1.2 * 0.3), 1e-3);
  EXPECT_EQ(drive.drive(0).speed, 0);
  for (int i = 0; i < 40; ++i) {
    drive.command(1, 0);
    drive.drive(50);
  }
  EXPECT_NEAR(drive.drive(0).speed, 1, 1e-6);
  EXPECT_NEAR(drive.driven(), 2 - 0.1 - 0.5 / 1.2, 0.01);
  EXPECT_NEAR(drive.drive(2000).speed, 0, 1e-6);
  drive.command(std::numeric_limits<double>::quiet_NaN(), 0);
  EXPECT_NEAR(drive.drive(100).speed, 0, 1e-6);
}

TEST(PlantDrive, CountsContactsAndScansFromWhereItIs) {
  PlantDriveParameters parameters = empty_plant();
  parameters.obstacles = {{.centre = {3, 3.25}, .half_length = 0.3, .half_width = 0.3}};
  parameters.lidar.noise = 0;
  parameters.lidar.dropouts = 0;
  PlantDrive drive(parameters);
  std::vector<float> ranges;
  drive.move_to({0, 3.25, 0}, 0.002);
  drive.scan(ranges);
  EXPECT_NEAR(static_cast<double>(ranges[ranges.size() / 2]), 3 - 0.3 - 0.8, 0.01);
  EXPECT_EQ(drive.contact_time(), 0);
  EXPECT_NEAR(drive.least_clearance(), 3 - 0.3 - 1.55, 1e-9);
  drive.move_to({1.5, 3.25, 0}, 0.002);
  EXPECT_EQ(drive.contact_time(), 0.002);
  EXPECT_EQ(drive.least_clearance(), 0);
  parameters.start = {3, 3.25, 0};
  EXPECT_THROW(PlantDrive{parameters}, std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
