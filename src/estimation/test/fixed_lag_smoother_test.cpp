// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/fixed_lag_smoother.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "pipescout/estimation/pipe_centre_line.hpp"
#include "simulated_flight.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;
using test::SimulatedFlight;

NavState newest(const FixedLagSmoother& smoother) {
  return smoother.state(smoother.keyframes() - 1);
}

StateMatrix newest_covariance(const FixedLagSmoother& smoother) {
  return smoother.covariance(smoother.keyframes() - 1);
}

TEST(FixedLagSmootherTest, TwoPositionsOfABodyAtRestAreAveraged) {
  // Known velocity, attitude and biases: positions are the only unknowns, and a prior of 1 m with
  // two fixes of 1 m leaves a variance of 1/3.
  FixedLagSmootherParameters parameters;
  parameters.imu_noise.accelerometer = 1e-6;
  parameters.imu_noise.accelerometer_bias = 1e-6;
  parameters.imu_noise.integration = 1e-5;
  FixedLagSmoother smoother(parameters);
  StateVector deviations = StateVector::Constant(1e-6);
  deviations.head<3>().setOnes();
  smoother.initialise(0, {}, deviations.cwiseAbs2().asDiagonal());
  smoother.add(GpsMeasurement{0, Vector3d(1, 0, 0), Eigen::Matrix3d::Identity()});
  smoother.add(ImuSample{0, 0.1, Vector3d::Zero(), Vector3d(0, 0, 9.81)});
  smoother.add(GpsMeasurement{0.1, Vector3d(2, 0, 3), Eigen::Matrix3d::Identity()});
  const UpdateReport& report = smoother.update(0.1);
  EXPECT_TRUE(report.new_keyframe);
  EXPECT_TRUE(report.converged);
  ASSERT_EQ(smoother.keyframes(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_LT((smoother.state(k).position - Vector3d(1, 0, 1)).norm(), 1e-6);
    EXPECT_NEAR(smoother.covariance(k)(0, 0), 1.0 / 3, 1e-6);
  }
  ASSERT_EQ(report.factors.size(), 2U);
  EXPECT_EQ(report.factors[0].kind, FactorKind::kGps);
  EXPECT_EQ(report.factors[0].outcome, Outcome::kAccepted);
  EXPECT_EQ(report.factors[0].degrees, 3);
  EXPECT_NEAR(report.factors[0].chi_square, 1, 1e-5);  // 0, 0, 1
  EXPECT_NEAR(report.factors[1].chi_square, 5, 1e-5);  // 1, 0, 2
}

TEST(FixedLagSmootherTest, KeyframeLimitShortensTheLag) {
  const SimulatedFlight flight(1, 30);
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.max_keyframes = 5;
  FixedLagSmoother smoother(parameters);
  smoother.initialise(0, flight.first, flight.first_covariance);
  for (int k = 0; k < 30; ++k) {
    flight.feed(smoother, k, true, true, true);
    EXPECT_LE(smoother.keyframes(), 5U);
  }
  EXPECT_LT((newest(smoother).position - flight.truth[29].position).norm(), 0.15);
}

TEST(FixedLagSmootherTest, FindsPoseOfTheRackAndLeverArm) {
  GlobalStates truth;
  truth.rack_position = Vector3d(3, -2, 1);
  truth.R_map_rack = SO3::from_roll_pitch_yaw({0.05, -0.05, 0.7});
  truth.gps_lever_arm = Vector3d(0.3, -0.2, 0.5);
  constexpr int kKeyframes = 200;
  const SimulatedFlight flight(5, kKeyframes, truth);
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.globals.rack_position = Vector3d(2.5, -1.5, 1.3);
  parameters.globals.R_map_rack = SO3::from_roll_pitch_yaw({0, 0, 0.5});
  parameters.global_deviations = {.rack_position = 1, .rack_rotation = 0.3, .gps_lever_arm = 0.5};
  FixedLagSmoother smoother(parameters);
  smoother.initialise(0, flight.first, flight.first_covariance);
  for (int k = 0; k < kKeyframes; ++k) {
    flight.feed(smoother, k, true, true, true);
  }
  const GlobalVector error = smoother.globals().local(truth);
  const GlobalVector deviations = smoother.global_covariance().diagonal().cwiseSqrt();
  for (int i = kRackPosition; i < kGpsTimeOffset; ++i) {
    EXPECT_LT(std::abs(error[i]), 4 * deviations[i]) << i;
  }
  EXPECT_LT(deviations.segment<3>(kRackPosition).maxCoeff(), 0.1);
  EXPECT_LT(deviations.segment<3>(kGpsLeverArm).maxCoeff(), 0.1);
  EXPECT_EQ(deviations[kOdometerScale], 0);  // not estimated
  EXPECT_EQ(smoother.globals().odometer_scale, 1);
}

TEST(FixedLagSmootherTest, FindsScaleAndMountOfTheOdometer) {
  constexpr int kKeyframes = 150;
  constexpr double kScale = 1.04;
  constexpr double kYaw = 0.05;
  // The body flies where it likes; its direction of travel is made up of the true displacement.
  // A crawler is simulated instead: constant speed along a direction in the body, slow turns.
  const ImuNoise noise = test::flight_parameters().imu_noise;
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.global_deviations = {.odometer_scale = 0.1, .mount_yaw = 0.1, .mount_pitch = 0.1};
  parameters.relinearisation.rotation = 1e-3;  // as GlobalDeviations asks for
  FixedLagSmoother smoother(parameters);
  constexpr double kSpeed = 1;
  constexpr double kTurn = 0.3;
  const Vector3d forward(std::cos(kYaw), std::sin(kYaw), 0);
  NavState x;
  x.velocity = kSpeed * forward;
  StateVector deviations = StateVector::Constant(0.01);
  smoother.initialise(0, x, deviations.cwiseAbs2().asDiagonal());
  const double dt = 0.01;
  for (int k = 1; k < kKeyframes; ++k) {
    for (int i = 0; i < 10; ++i) {
      const Vector3d rate(0, 0, kTurn);
      // Velocity turns with the body: the force is across the travel.
      const Vector3d force = rate.cross(kSpeed * forward) + Vector3d(0, 0, 9.81);
      const auto draw = [&] { return Vector3d(normal(engine), normal(engine), normal(engine)); };
      smoother.add(ImuSample{0.1 * (k - 1) + dt * i, dt, rate + noise.gyro * 10 * draw(),
                             force + noise.accelerometer * 10 * draw()});
      const SO3 next = x.R_map_body * SO3::about_z(kTurn * dt);
      // The chord of the arc.
      const SO3 middle = x.R_map_body * SO3::about_z(0.5 * kTurn * dt);
      x.position += middle * forward * (kSpeed * std::sin(0.5 * kTurn * dt) / (0.5 * kTurn));
      x.R_map_body = next;
    }
    x.velocity = x.R_map_body * (kSpeed * forward);
    const double to = 0.1 * k;
    smoother.add(OdometerMeasurement{to - 0.1, to, 0.1 * kSpeed / kScale + 1e-3 * normal(engine),
                                     1e-3, 2e-3});
    smoother.add(NonHolonomicMeasurement{to, 0.02, 0.02});
    if (k % 10 == 0) {
      smoother.add(GpsMeasurement{
          to, x.position + 0.05 * Vector3d(normal(engine), normal(engine), normal(engine)),
          0.0025 * Eigen::Matrix3d::Identity()});
    }
    smoother.update(to);
  }
  const GlobalVector sigma = smoother.global_covariance().diagonal().cwiseSqrt();
  EXPECT_NEAR(smoother.globals().odometer_scale, kScale, 4 * sigma[kOdometerScale]);
  EXPECT_LT(sigma[kOdometerScale], 0.02);
  EXPECT_NEAR(smoother.globals().mount_yaw, kYaw, 4 * sigma[kMountYaw]);
  EXPECT_LT(sigma[kMountYaw], 0.05);
  EXPECT_LT((newest(smoother).position - x.position).norm(), 0.2);
}

TEST(FixedLagSmootherTest, AWrongFirstGuessIsLeftByDampedSteps) {
  // Turned by 2 rad and 5 m away, and sure of neither.
  const SimulatedFlight flight(2, 40);
  FixedLagSmootherParameters parameters = test::flight_parameters();
  FixedLagSmoother smoother(parameters);
  NavState guess = flight.truth[0];
  guess.R_map_body = guess.R_map_body * SO3::about_z(2);
  guess.position += Vector3d(5, 0, 0);
  StateVector deviations;
  deviations << Vector3d::Constant(10), Vector3d::Constant(2), Vector3d::Constant(2),
      Vector3d::Constant(0.02), Vector3d::Constant(0.1);
  smoother.initialise(0, guess, deviations.cwiseAbs2().asDiagonal());
  for (int k = 0; k < 40; ++k) {
    const UpdateReport& report = flight.feed(smoother, k, true, true, true);
    ASSERT_EQ(report.reset, ResetReason::kNone);
  }
  const StateVector error = newest(smoother).local(flight.truth[39]);
  EXPECT_LT(error.segment<3>(kPosition).norm(), 0.1);
  EXPECT_LT(error.segment<3>(kRotation).norm(), 0.02);
}

TEST(FixedLagSmootherTest, PropagatesAtTheRateOfTheImu) {
  const SimulatedFlight flight(4, 30);
  FixedLagSmoother smoother(test::flight_parameters());
  EXPECT_FALSE(smoother.propagated());
  smoother.initialise(0, flight.first, flight.first_covariance);
  for (int k = 0; k < 29; ++k) {
    flight.feed(smoother, k, true, true, true);
  }
  const auto at_keyframe = smoother.propagated();
  ASSERT_TRUE(at_keyframe);
  EXPECT_NEAR(at_keyframe->time, 2.8, 1e-9);
  EXPECT_LT(at_keyframe->state.local(newest(smoother)).norm(), 1e-12);
  for (std::size_t i = 280; i < 290; ++i) {
    smoother.add(flight.imu[i]);
  }
  const auto ahead = smoother.propagated();
  const StateMatrix covariance_ahead = smoother.propagated_covariance();
  EXPECT_NEAR(ahead->time, 2.9, 1e-9);
  // An update without measurements is the same propagation.
  smoother.update(2.9);
  EXPECT_LT(ahead->state.local(newest(smoother)).norm(), 1e-9);
  EXPECT_LT((covariance_ahead - newest_covariance(smoother)).norm(),
            1e-3 * covariance_ahead.norm());
}

TEST(FixedLagSmootherTest, WeldsHeadingsAndStandstillsBoundACrawler) {
  // Along a straight pipe to the north-east at 0.5 m/s; the odometer slips by 3 % and no GPS
  // reaches it. Welds every 6 m; it halts for the last two seconds.
  constexpr double kSpeed = 0.5;
  constexpr double kCourse = 0.25 * std::numbers::pi;
  const SO3 R_map_body = SO3::about_z(kCourse);
  const Vector3d along = R_map_body * Vector3d::UnitX();
  const PipeCentreLine pipe({Vector3d::Zero(), 100 * along});
  const Vector3d sensor(0.2, 0, 0);
  FixedLagSmoother smoother(test::flight_parameters());
  NavState x;
  x.R_map_body = R_map_body;
  x.velocity = kSpeed * along;
  StateVector deviations;
  deviations << Vector3d::Constant(0.05), Vector3d::Constant(0.05), Vector3d::Constant(0.05),
      Vector3d::Constant(0.01), Vector3d::Constant(0.05);
  smoother.initialise(0, x, deviations.cwiseAbs2().asDiagonal());
  constexpr int kKeyframes = 420;
  constexpr int kHalt = 400;
  int welds = 0;
  for (int k = 1; k <= kKeyframes; ++k) {
    const double now = 0.1 * k;
    const bool halted = k > kHalt;
    for (int i = 0; i < 10; ++i) {
      smoother.add(ImuSample{now - 0.1 + 0.01 * i, 0.01, Vector3d(0.002, 0, -0.003),
                             Vector3d(k == kHalt ? -kSpeed / 0.1 : 0, 0.02, 9.81)});
    }
    // It brakes evenly over the interval before kHalt.
    const double moved = halted ? 0 : 0.1 * kSpeed * (k == kHalt ? 0.5 : 1);
    x.position += moved * along;
    smoother.add(OdometerMeasurement{now - 0.1, now, 0.97 * moved, 0.003, 0.003});
    smoother.add(HeadingMeasurement{now, kCourse, 0.05});
    const double passed = x.position.norm() + sensor.x();
    const double weld = 6 * std::floor(passed / 6);
    if (weld > 0 && passed - weld < moved) {
      const double at = now - (passed - weld) / kSpeed;
      const auto measured = pipe.weld(at, weld, 0.02, 0.02, sensor);
      ASSERT_TRUE(measured);
      EXPECT_EQ(smoother.add(*measured), Outcome::kWaiting);
      ++welds;
    }
    if (halted) {
      smoother.add(ZeroVelocityMeasurement{now, 0.01});
    }
    ASSERT_EQ(smoother.update(now).reset, ResetReason::kNone);
  }
  EXPECT_EQ(welds, 3);
  const NavState end = newest(smoother);
  // By the odometer alone 0.6 m would be missing.
  EXPECT_LT((end.position - x.position).norm(), 0.15);
  EXPECT_LT(end.velocity.norm(), 0.02);
  EXPECT_LT(std::abs(end.R_map_body.roll_pitch_yaw().z() - kCourse), 0.05);
}

TEST(FixedLagSmootherTest, SecondsSince1970AreAsGoodAsAnyOther) {
  constexpr int kKeyframes = 40;
  constexpr double kEpoch = 1.76e9;
  SimulatedFlight flight(6, kKeyframes);
  FixedLagSmoother early(test::flight_parameters());
  FixedLagSmoother late(test::flight_parameters());
  early.initialise(0, flight.first, flight.first_covariance);
  for (int k = 0; k < kKeyframes; ++k) {
    flight.feed(early, k, true, true, true);
  }
  const auto shift = [](auto& list) {
    for (auto& m : list) {
      if constexpr (requires { m.to_time; }) {
        m.from_time += kEpoch;
        m.to_time += kEpoch;
      } else {
        m.time += kEpoch;
      }
    }
  };
  shift(flight.imu);
  shift(flight.gps);
  shift(flight.vision);
  shift(flight.odometry);
  late.initialise(kEpoch, flight.first, flight.first_covariance);
  for (std::size_t k = 0; k < kKeyframes; ++k) {
    for (std::size_t i = k == 0 ? 0 : (k - 1) * 10; i < k * 10; ++i) {
      EXPECT_EQ(late.add(flight.imu[i]), Outcome::kAccepted);
    }
    if (k > 0) {
      late.add(flight.odometry[k]);
    }
    late.add(flight.gps[k]);
    late.add(flight.vision[k]);
    const UpdateReport& report =
        late.update(kEpoch + SimulatedFlight::time_of(static_cast<int>(k)));
    EXPECT_EQ(report.coasted, 0);
    EXPECT_EQ(report.factors.size(), k == 0 ? 2U : 3U);
  }
  EXPECT_LT(newest(early).local(newest(late)).norm(), 1e-4);
}

TEST(FixedLagSmootherTest, ParametersAreValidated) {
  const auto refused = [](auto&& change) {
    FixedLagSmootherParameters parameters;
    change(parameters);
    try {
      FixedLagSmoother smoother(parameters);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_THAT(refused([](auto& p) { p.lag = 0; }), testing::StartsWith("lag: 0 is outside"));
  EXPECT_THAT(refused([](auto& p) { p.max_keyframes = 2; }), testing::HasSubstr("max_keyframes"));
  EXPECT_THAT(refused([](auto& p) { p.max_iterations = 0; }), testing::HasSubstr("max_iterations"));
  EXPECT_THAT(refused([](auto& p) { p.global_deviations.mount_yaw = -1; }),
              testing::HasSubstr("mount_yaw"));
  EXPECT_THAT(refused([](auto& p) { p.globals.odometer_scale = std::nan(""); }),
              testing::HasSubstr("globals"));
  EXPECT_THAT(refused([](auto& p) { p.robustness[2].width = 0; }), testing::HasSubstr("width"));
  EXPECT_THAT(refused([](auto& p) { p.imu_noise.gyro = 0; }), testing::HasSubstr("gyro"));
  FixedLagSmoother smoother({});
  EXPECT_THROW(smoother.initialise(std::nan(""), {}, StateMatrix::Identity()),
               std::invalid_argument);
  EXPECT_THROW(smoother.initialise(0, {}, StateMatrix::Zero()), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::estimation
