// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/world.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace pipescout::simulation {
namespace {

TEST(World, IsDrawnFromItsRangesAndFillsThem) {
  const WorldRanges ranges;
  double least = 1;
  double most = -1;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const World world = draw_world(ranges, seed);
    EXPECT_GT(world.gps_correlation_time, 0);
    EXPECT_LE(world.gps_correlation_time, 60);
    EXPECT_GE(world.imu_noise, 0.5);
    EXPECT_LE(world.imu_noise, 2);
    EXPECT_NE(world.gps_stamp_offset, world.odometer_stamp_offset);
    EXPECT_EQ(world.wheel_scale, draw_world(ranges, seed).wheel_scale);
    least = std::min(least, world.wheel_scale);
    most = std::max(most, world.wheel_scale);
  }
  EXPECT_GE(least, -0.02);
  EXPECT_LT(least, -0.018);
  EXPECT_GT(most, 0.018);
  EXPECT_LE(most, 0.02);
}

TEST(World, RefusesWrongRanges) {
  EXPECT_THROW((void)draw_world({.imu_noise = {0, 1}}, 1), std::invalid_argument);
  EXPECT_THROW((void)draw_world({.lost = {0.5, 0.1}}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
