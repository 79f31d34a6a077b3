// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/run_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace pipescout::estimation_study {
namespace {

/// Runs whose errors are normal, and `scale` times what they are said to be.
std::vector<RunScore> made_up(double scale) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  std::vector<RunScore> runs(20);
  for (RunScore& run : runs) {
    for (int second = 0; second < 400; ++second) {
      double nees = 0;
      for (int i = 0; i < 9; ++i) {
        nees += std::pow(scale * normal(engine), 2);
      }
      run.estimates.push_back({.time = 1.0 * second, .nees = nees});
      run.estimates.push_back({.time = second + 0.1});  // without NEES
      double nis = 0;
      for (int i = 0; i < 3; ++i) {
        nis += std::pow(scale * normal(engine), 2);
      }
      run.innovations.push_back({.time = 1.0 * second, .nis = nis});
    }
  }
  return runs;
}

TEST(Consistency, HoldsForErrorsThatAreAsStated) {
  const Consistency good = consistency(made_up(1));
  EXPECT_NEAR(good.nees, 9, 0.2);
  EXPECT_NEAR(good.nis, 3, 0.1);
  EXPECT_NEAR(good.nees_share, 0.95, 0.04);  // binomial, 400 times
  EXPECT_NEAR(good.nis_share, 0.95, 0.04);
  EXPECT_NEAR(good.nees_below, 0.025, 0.025);
  EXPECT_LT(consistency(made_up(1.3)).nees_share, 0.2);
  const Consistency careful = consistency(made_up(0.7));
  EXPECT_LT(careful.nees_share, 0.2);
  EXPECT_GT(careful.nees_below, 0.8);
}

TEST(ImuNoise, IsThatOfTheDataSheet) {
  const auto imu = simulation::ImuParameters::industrial();
  const estimation::ImuNoise noise = imu_noise(imu);
  EXPECT_NEAR(noise.gyro, imu.gyro.noise_density, 0.01 * noise.gyro);
  EXPECT_NEAR(noise.accelerometer, imu.accelerometer.noise_density, 0.01 * noise.accelerometer);
  EXPECT_NO_THROW(noise.validate());
  EXPECT_NO_THROW(imu_noise({}).validate());
}

class EveryVehicle : public testing::TestWithParam<Vehicle> {};

TEST_P(EveryVehicle, IsFollowed) {
  const RunOptions options{.duration = 80};
  const VehicleRun run = vehicle_run(GetParam(), options, 3);
  const RunScore score = score_run(run, options, estimator_parameters(run, options));
  EXPECT_LT(score.started, 40);
  ASSERT_GT(score.estimates.size(), 200U);
  EXPECT_LT(score.largest_position_error(), 1);
  EXPECT_LT(score.rotation_rmse(), 0.05);
  EXPECT_LT(score.velocity_rmse(), 0.2);
  EXPECT_EQ(score.status.phase, estimation::Phase::kRunning);
  EXPECT_EQ(score.false_reacquisitions, 0U);
}

TEST_P(EveryVehicle, DriftsOverASilence) {
  const Sensor silent = GetParam() == Vehicle::kCrawler ? Sensor::kWeld : Sensor::kGps;
  const RunOptions options{.duration = 80,
                           .silences = {{.sensor = silent, .begin = 60, .duration = 15}}};
  const VehicleRun run = vehicle_run(GetParam(), options, 3);
  const RunScore score = score_run(run, options, estimator_parameters(run, options));
  ASSERT_EQ(score.silences.size(), 1U);
  EXPECT_NEAR(score.silences[0].way, way_at(run, 75) - way_at(run, 60), 1);
  EXPECT_GT(score.silences[0].drift, 0);
  EXPECT_LT(score.silences[0].drift, 1);
}

INSTANTIATE_TEST_SUITE_P(RunScore, EveryVehicle,
                         testing::Values(Vehicle::kGroundRobot, Vehicle::kUav, Vehicle::kCrawler));

}  // namespace
}  // namespace pipescout::estimation_study
