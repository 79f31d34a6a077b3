// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_simulation/plant_drive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace pipescout {
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
  EXPECT_NEAR(drive.truth().steering, std::atan(1.2 * 0.3), 1e-3);
  EXPECT_EQ(drive.driven(), 0);
  for (int i = 0; i < 40; ++i) {
    drive.command(1, 0);
    drive.drive(50);
  }
  EXPECT_NEAR(drive.truth().speed, 1, 1e-6);
  drive.drive(2000);
  EXPECT_NEAR(drive.truth().speed, 0, 1e-6);
  drive.command(std::numeric_limits<double>::quiet_NaN(), 0);
  drive.drive(100);
  EXPECT_NEAR(drive.truth().speed, 0, 1e-6);
}

TEST(PlantDrive, CountsContacts) {
  PlantDriveParameters parameters = empty_plant();
  parameters.obstacles = {{.centre = {3, 3.25}, .half_length = 0.3, .half_width = 0.3}};
  PlantDrive drive(parameters);
  while (drive.time() < 8) {
    drive.command(1, 0);
    drive.drive(50);
  }
  EXPECT_GT(drive.collisions(), 0U);
  EXPECT_EQ(drive.least_clearance(), 0);
  parameters.start = {.x = 3, .y = 3.25};
  EXPECT_THROW(PlantDrive{parameters}, std::invalid_argument);
}

TEST(PlantDrive, SeesThePipeOnItsLeft) {
  PlantDriveParameters parameters = empty_plant();
  EXPECT_FALSE(PlantDrive(parameters).range_to_pipe().has_value());
  parameters.start = {.x = 10, .y = 3};
  EXPECT_NEAR(PlantDrive(parameters).range_to_pipe().value_or(0), 6.5 - 0.75 - 3, 1e-9);
  parameters.start.heading = 3.14159265;
  EXPECT_NEAR(PlantDrive(parameters).range_to_pipe().value_or(0), 3 - 0.75, 1e-9);
}

}  // namespace
}  // namespace pipescout
