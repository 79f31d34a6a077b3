// SPDX-License-Identifier: Apache-2.0
// Whether the smoother knows how well it knows.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <random>

#include "simulated_flight.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using test::SimulatedFlight;

NavState newest(const FixedLagSmoother& smoother) {
  return smoother.state(smoother.keyframes() - 1);
}

StateMatrix newest_covariance(const FixedLagSmoother& smoother) {
  return smoother.covariance(smoother.keyframes() - 1);
}

/// Mean of the normalised squared errors of the newest state over 20 seeds.
double mean_nees(bool gps, bool vision, bool odometry) {
  constexpr int kSeeds = 20;
  constexpr int kKeyframes = 60;
  double sum = 0;
  int count = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const SimulatedFlight flight(static_cast<std::uint64_t>(seed), kKeyframes);
    FixedLagSmootherParameters parameters = test::flight_parameters();
    parameters.lag = 1;
    FixedLagSmoother smoother(parameters);
    smoother.initialise(0, flight.first, flight.first_covariance);
    for (int k = 0; k < kKeyframes; ++k) {
      flight.feed(smoother, k, gps, vision, odometry);
      if (k >= 20 && k % 5 == 0) {
        const StateVector error = newest(smoother).local(flight.truth[static_cast<std::size_t>(k)]);
        sum += error.dot(newest_covariance(smoother).llt().solve(error));
        ++count;
      }
    }
  }
  return sum / count;
}

TEST(SmootherConsistencyTest, IsAsGoodAsItSays) {
  // 20 independent runs: were each run's values equal, the mean of 15 would be within
  // sqrt(30 / 20) = 1.2; three of these to either side.
  const double all = mean_nees(true, true, true);
  const double no_vision = mean_nees(true, false, true);
  const double vision_only = mean_nees(false, true, false);
  std::printf("NEES of 15: all sensors %.2f, without vision %.2f, vision alone %.2f\n", all,
              no_vision, vision_only);
  EXPECT_NEAR(all, 15, 3.7);
  EXPECT_NEAR(no_vision, 15, 3.7);
  EXPECT_NEAR(vision_only, 15, 3.7);
}

/// Mean of the normalised squared errors of the N global states from `place` on, which are drawn
/// anew in each of 20 runs. The rack is first seen at keyframe `seen`.
template <int N>
double mean_global_nees(const GlobalDeviations& deviations, int place, int seen) {
  constexpr int kSeeds = 20;
  constexpr int kKeyframes = 120;
  double sum = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 engine(static_cast<std::uint64_t>(1000 * seed));
    std::normal_distribution<double> normal;
    FixedLagSmootherParameters parameters = test::flight_parameters();
    parameters.lag = 1;
    parameters.global_deviations = deviations;
    const GlobalStates truth = parameters.globals.retract(deviations.tangent().cwiseProduct(
        GlobalVector::NullaryExpr([&] { return normal(engine); })));
    const SimulatedFlight flight(static_cast<std::uint64_t>(seed), kKeyframes, truth);
    FixedLagSmoother smoother(parameters);
    smoother.initialise(0, flight.first, flight.first_covariance);
    for (int k = 0; k < kKeyframes; ++k) {
      flight.feed(smoother, k, true, k >= seen, true);
    }
    const Eigen::Matrix<double, N, 1> error = smoother.globals().local(truth).segment<N>(place);
    const Eigen::Matrix<double, N, N> covariance =
        smoother.global_covariance().block<N, N>(place, place);
    sum += error.dot(covariance.llt().solve(error));
  }
  return sum / kSeeds;
}

// Of N dimensions over 20 runs the deviation of the mean is sqrt(2 N / 20).

TEST(SmootherConsistencyTest, SharedStatesAreAsGoodAsTheySay) {
  const double nees = mean_global_nees<9>(
      {.rack_position = 0.5, .rack_rotation = 0.1, .gps_lever_arm = 0.3}, kRackPosition, 0);
  std::printf("NEES of 9: pose of the rack and lever arm %.2f\n", nees);
  EXPECT_NEAR(nees, 9, 3 * 0.95);
}

TEST(SmootherConsistencyTest, TheScaleOfTheImuIsAsGoodAsItSays) {
  const GlobalDeviations deviations{.gyro_scale = 0.01,
                                    .gyro_misalignment = 0.005,
                                    .accelerometer_scale = 0.005,
                                    .accelerometer_misalignment = 0.005};
  const double nees = mean_global_nees<kImuScaleSize>(deviations, kImuScale, 0);
  std::printf("NEES of 18: scale of the IMU %.2f\n", nees);
  EXPECT_NEAR(nees, 18, 3 * 1.34);
}

TEST(SmootherConsistencyTest, WhatIsSeenLateIsLinearisedWhereItIsFound) {
  // The IMU has told of its scale, and that is marginalised, long before the rack is seen.
  const GlobalDeviations deviations{.rack_position = 0.5,
                                    .rack_rotation = 0.1,
                                    .gps_lever_arm = 0.3,
                                    .gyro_scale = 0.01,
                                    .accelerometer_misalignment = 0.005};
  const double nees = mean_global_nees<6>(deviations, kRackPosition, 60);
  std::printf("NEES of 6: pose of the rack, seen late %.2f\n", nees);
  EXPECT_NEAR(nees, 6, 3 * 0.77);
}

TEST(SmootherConsistencyTest, LearnsNothingAboutWhatCannotBeSeen) {
  // Odometry and IMU alone say nothing about position and heading in the map. Without consistent
  // linearisation their information would grow all the same.
  constexpr int kKeyframes = 100;
  const SimulatedFlight flight(8, kKeyframes);
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.lag = 0.5;
  FixedLagSmoother smoother(parameters);
  // A velocity that is known in the map tells the heading, once the odometry has it in the body.
  StateMatrix first_covariance = flight.first_covariance;
  first_covariance.diagonal().segment<3>(kVelocity).setConstant(1e4);
  smoother.initialise(0, flight.first, first_covariance);
  for (int k = 0; k < kKeyframes; ++k) {
    flight.feed(smoother, k, false, false, true);
    const StateMatrix covariance = newest_covariance(smoother);
    const Eigen::Matrix3d r = newest(smoother).R_map_body.matrix();
    const Eigen::Matrix3d turn = r * covariance.block<3, 3>(kRotation, kRotation) * r.transpose();
    constexpr double kLinearisation = 1e-3;
    EXPECT_GT(std::sqrt(turn(2, 2)), 0.03 * (1 - kLinearisation)) << k;
    for (int i = 0; i < 3; ++i) {
      EXPECT_GT(std::sqrt(covariance(i, i)), 0.2 * (1 - kLinearisation)) << k;
    }
  }
}

TEST(SmootherConsistencyTest, TheGateRefusesTheShareItIsSetTo) {
  constexpr int kSeeds = 10;
  constexpr int kKeyframes = 60;
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.robustness[static_cast<std::size_t>(FactorKind::kGps)].gate_probability = 0.9;
  double gated = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const SimulatedFlight flight(static_cast<std::uint64_t>(seed), kKeyframes);
    FixedLagSmoother smoother(parameters);
    smoother.initialise(0, flight.first, flight.first_covariance);
    for (int k = 0; k < kKeyframes; ++k) {
      flight.feed(smoother, k, true, true, true);
    }
    gated += static_cast<double>(
        smoother.counts(FactorKind::kGps)[static_cast<std::size_t>(Outcome::kGated)]);
  }
  // Deviation of the share of 600: sqrt(0.09 / 600) = 0.012.
  EXPECT_NEAR(gated / (kSeeds * kKeyframes), 0.1, 3 * 0.012);
}

TEST(SmootherConsistencyTest, ALongerLagChangesTheNewestStateHardly) {
  // Marginalisation loses nothing but what linearisation costs.
  constexpr int kKeyframes = 80;
  const SimulatedFlight flight(3, kKeyframes);
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.lag = 0.5;
  FixedLagSmoother brief(parameters);
  parameters.lag = 100;
  parameters.max_keyframes = 100;
  FixedLagSmoother full(parameters);
  brief.initialise(0, flight.first, flight.first_covariance);
  full.initialise(0, flight.first, flight.first_covariance);
  for (int k = 0; k < kKeyframes; ++k) {
    flight.feed(brief, k, true, true, true);
    flight.feed(full, k, true, true, true);
    EXPECT_LE(brief.keyframes(), 6U);
  }
  EXPECT_EQ(full.keyframes(), static_cast<std::size_t>(kKeyframes));
  const StateVector apart = newest(brief).local(newest(full));
  const StateVector deviations = newest_covariance(full).diagonal().cwiseSqrt();
  EXPECT_LT(apart.cwiseQuotient(deviations).cwiseAbs().maxCoeff(), 0.1);
  const StateVector brief_deviations = newest_covariance(brief).diagonal().cwiseSqrt();
  EXPECT_LT((brief_deviations - deviations).cwiseQuotient(deviations).cwiseAbs().maxCoeff(), 0.01);
}

TEST(SmootherConsistencyTest, KeyframesMayBeAsDenseAsTheImu) {
  // Links over one sample are a hundred times surer than those over ten.
  constexpr int kKeyframes = 20;
  double sum = 0;
  constexpr int kSeeds = 10;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const SimulatedFlight flight(static_cast<std::uint64_t>(seed), kKeyframes);
    FixedLagSmootherParameters parameters = test::flight_parameters();
    parameters.lag = 0.2;
    FixedLagSmoother smoother(parameters);
    smoother.initialise(0, flight.first, flight.first_covariance);
    for (std::size_t k = 1; k < kKeyframes; ++k) {
      for (std::size_t i = (k - 1) * 10; i < k * 10; ++i) {
        smoother.add(flight.imu[i]);
        if (i + 1 == k * 10) {
          smoother.add(flight.vision[k]);
        }
        const ImuSample& sample = flight.imu[i];
        ASSERT_EQ(smoother.update(sample.time + sample.duration).reset, ResetReason::kNone);
      }
    }
    const StateVector error = newest(smoother).local(flight.truth.back());
    sum += error.dot(newest_covariance(smoother).llt().solve(error));
  }
  // Deviation of the mean: sqrt(30 / 10) = 1.7.
  EXPECT_NEAR(sum / kSeeds, 15, 3 * 1.7);
}

}  // namespace
}  // namespace pipescout::estimation
