// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/world_run.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace pipescout::estimation_study {
namespace {

class EveryVehicleInAWorld : public testing::TestWithParam<Vehicle> {};

TEST_P(EveryVehicleInAWorld, IsFollowedToldOrNot) {
  const WorldScore score = score_world(GetParam(), 60, {}, 3);
  for (const RunScore* run : {&score.nominal, &score.told}) {
    ASSERT_FALSE(run->estimates.empty());
    EXPECT_LT(run->position_rmse(), 5);
    EXPECT_GE(run->position_coverage(), 0);
  }
  EXPECT_NE(score.nominal.position_rmse(), score.told.position_rmse());
}

INSTANTIATE_TEST_SUITE_P(Vehicles, EveryVehicleInAWorld,
                         testing::Values(Vehicle::kGroundRobot, Vehicle::kUav, Vehicle::kCrawler));

/// Its sideways slip is part of the truth: where it is ten times as large as the preset has it, an
/// estimator that takes it for white noise is off by more than it states.
TEST(ScoreWorld, AnEstimatorThatIsToldTheTruthKnowsHowAGroundRobotSlipsSideways) {
  double covered = 0;
  const std::vector<std::uint64_t> seeds{3, 4, 6};
  for (const std::uint64_t seed : seeds) {
    const WorldScore score =
        score_world(Vehicle::kGroundRobot, 120, {.side_slip = {0.1, 0.1}}, seed);
    covered += score.told.position_coverage() / static_cast<double>(seeds.size());
  }
  EXPECT_GT(covered, 0.88);
}

/// What the preset allows for costs some accuracy where it does not occur.
TEST(ScoreWorld, InAWorldOfIndependentErrorsToldIsNoWorseThanThePreset) {
  const simulation::WorldRanges agreeing{.gps_correlation_time = {0, 0},
                                         .gps_correlated_share = {0, 0},
                                         .imu_noise = {1, 1},
                                         .stamp_offset = {0, 0},
                                         .wheel_scale = {0, 0},
                                         .slip = {1, 1},
                                         .side_slip = {0.01, 0.01},
                                         .heights_missing = {0, 0},
                                         .lost = {0, 0}};
  const WorldScore score = score_world(Vehicle::kUav, 40, agreeing, 2);
  EXPECT_LE(score.told.position_rmse(), score.nominal.position_rmse());
  EXPECT_LT(score.nominal.position_rmse(), 0.1);
  EXPECT_LT(score.told.position_rmse(), 0.03);
}

}  // namespace
}  // namespace pipescout::estimation_study
