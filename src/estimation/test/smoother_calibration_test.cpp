// SPDX-License-Identifier: Apache-2.0
// What hardly changes about the sensors, found while driving.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pipescout/estimation/fixed_lag_smoother.hpp"
#include "simulated_drive.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using test::SimulatedDrive;

constexpr int kKeyframes = 300;
const Vector3d kWheel(-0.8, 0.3, -0.4);  // NOLINT(cert-err58-cpp): does not throw

GlobalStates true_globals() {
  GlobalStates truth;
  truth.odometer_scale = 1.03;
  truth.mount_yaw = 0.04;
  truth.mount_pitch = -0.02;
  truth.gps_lever_arm = Vector3d(0.4, -0.3, 0.6);
  truth.gps_time_offset = 0.05;
  return truth;
}

/// Feeds GPS, odometer and non-holonomic measurements of a whole drive.
FixedLagSmoother driven(const SimulatedDrive& drive, const FixedLagSmootherParameters& parameters) {
  FixedLagSmoother smoother(parameters);
  smoother.initialise(0, drive.first, drive.first_covariance);
  for (int k = 1; k < kKeyframes; ++k) {
    const auto i = static_cast<std::size_t>(k);
    for (std::size_t s = (i - 1) * SimulatedDrive::kImuPerKeyframe;
         s < i * SimulatedDrive::kImuPerKeyframe; ++s) {
      smoother.add(drive.imu[s]);
    }
    smoother.add(drive.odometer[i]);
    smoother.add(drive.non_holonomic[i]);
    if (k % 2 == 0) {
      smoother.add(drive.gps[i]);
    }
    EXPECT_EQ(smoother.update(SimulatedDrive::time_of(k)).reset, ResetReason::kNone);
  }
  return smoother;
}

double position_error(const FixedLagSmoother& smoother, const SimulatedDrive& drive) {
  return (smoother.state(smoother.keyframes() - 1).position - drive.truth.back().position).norm();
}

class SmootherCalibrationTest : public testing::TestWithParam<std::uint64_t> {};

TEST_P(SmootherCalibrationTest, FindsTimeOffsetOfTheGps) {
  const GlobalStates truth = true_globals();
  const SimulatedDrive drive(GetParam(), kKeyframes, truth, kWheel);
  FixedLagSmootherParameters parameters = test::drive_parameters();
  parameters.globals = truth;
  parameters.globals.gps_time_offset = 0;
  const double ignored = position_error(driven(drive, parameters), drive);
  parameters.global_deviations.gps_time_offset = 0.1;
  const FixedLagSmoother smoother = driven(drive, parameters);
  const double deviation = std::sqrt(smoother.global_covariance()(kGpsTimeOffset, kGpsTimeOffset));
  EXPECT_LT(deviation, 0.003);
  EXPECT_NEAR(smoother.globals().gps_time_offset, truth.gps_time_offset, 4 * deviation);
  EXPECT_LT(position_error(smoother, drive), 0.06);
  EXPECT_LT(position_error(smoother, drive), 0.7 * ignored);
}

TEST_P(SmootherCalibrationTest, FindsAllAboutTheAntennaAndTheWheelTogether) {
  const GlobalStates truth = true_globals();
  const SimulatedDrive drive(GetParam(), kKeyframes, truth, kWheel);
  FixedLagSmootherParameters parameters = test::drive_parameters();
  parameters.global_deviations = {.odometer_scale = 0.05,
                                  .mount_yaw = 0.05,
                                  .mount_pitch = 0.05,
                                  .gps_lever_arm = 0.5,
                                  .gps_time_offset = 0.1};
  parameters.relinearisation.rotation = 1e-3;
  const FixedLagSmoother smoother = driven(drive, parameters);
  const GlobalVector error = smoother.globals().local(truth);
  const GlobalVector deviations = smoother.global_covariance().diagonal().cwiseSqrt();
  for (const int i : {kOdometerScale, kMountYaw, kMountPitch, kGpsLeverArm, kGpsLeverArm + 1,
                      kGpsLeverArm + 2, kGpsTimeOffset}) {
    EXPECT_LT(std::abs(error[i]), 4 * deviations[i]) << i;
  }
  EXPECT_LT(deviations[kOdometerScale], 0.003);
  EXPECT_LT(deviations[kMountYaw], 0.01);
  EXPECT_LT(deviations[kGpsTimeOffset], 0.01);
}

TEST_P(SmootherCalibrationTest, FindsTheScaleOfTheGyroAboutTheAxisItTurnsAbout) {
  GlobalStates truth = true_globals();
  truth.imu_scale = test::wrong_scale();
  const SimulatedDrive drive(GetParam(), kKeyframes, truth, kWheel);
  FixedLagSmootherParameters parameters = test::drive_parameters();
  parameters.globals = truth;
  parameters.globals.imu_scale = {};
  parameters.global_deviations = {.gyro_scale = 0.02,
                                  .gyro_misalignment = 0.01,
                                  .accelerometer_scale = 0.01,
                                  .accelerometer_misalignment = 0.01};
  const FixedLagSmoother smoother = driven(drive, parameters);
  const GlobalVector error = smoother.globals().local(truth);
  const GlobalVector deviations = smoother.global_covariance().diagonal().cwiseSqrt();
  for (int i = kImuScale; i < kOwnStates; ++i) {
    EXPECT_LT(std::abs(error[i]), 4 * deviations[i]) << i;
  }
  EXPECT_LT(deviations[kImuScale + 8], 0.25 * parameters.global_deviations.gyro_scale);
}

TEST_P(SmootherCalibrationTest, TheWheelMayBeAwayFromTheOrigin) {
  const GlobalStates truth = true_globals();
  SimulatedDrive drive(GetParam(), kKeyframes, truth, kWheel);
  FixedLagSmootherParameters parameters = test::drive_parameters();
  parameters.globals = truth;
  const auto velocity_error = [&] {
    const FixedLagSmoother smoother = driven(drive, parameters);
    return (smoother.state(smoother.keyframes() - 1).velocity - drive.truth.back().velocity).norm();
  };
  EXPECT_LT(velocity_error(), 0.03);
  for (OdometerMeasurement& m : drive.odometer) {
    m.sensor.setZero();
  }
  for (NonHolonomicMeasurement& m : drive.non_holonomic) {
    m.sensor.setZero();
  }
  // The body turns by 0.4 rad/s, 0.85 m from the wheel.
  EXPECT_GT(velocity_error(), 0.2);
}

INSTANTIATE_TEST_SUITE_P(Seeds, SmootherCalibrationTest, testing::Values(1, 2, 3));

TEST(ZeroAngularRateTest, ABodyThatDoesNotTurnShowsTheBiasOfItsGyro) {
  const Vector3d bias(0.01, -0.02, 0.03);
  FixedLagSmoother smoother(test::drive_parameters());
  StateVector deviations = StateVector::Constant(0.05);
  smoother.initialise(0, {}, deviations.cwiseAbs2().asDiagonal());
  for (int k = 1; k <= 50; ++k) {
    const double now = 0.1 * k;
    for (int i = 0; i < 10; ++i) {
      smoother.add(ImuSample{now - 0.1 + 0.01 * i, 0.01, bias, Vector3d(0, 0, 9.81)});
    }
    smoother.add(ZeroVelocityMeasurement{now, 0.01});
    EXPECT_EQ(smoother.add(ZeroAngularRateMeasurement{now, bias, 0.01}), Outcome::kWaiting);
    EXPECT_EQ(smoother.add(ZeroAngularRateMeasurement{now, bias, 0.01}), Outcome::kDuplicate);
    ASSERT_EQ(smoother.update(now).reset, ResetReason::kNone);
  }
  const std::size_t last = smoother.keyframes() - 1;
  EXPECT_LT((smoother.state(last).gyro_bias - bias).norm(), 1e-3);
  const StateMatrix covariance = smoother.covariance(last);
  const double deviation = std::sqrt(covariance(kGyroBias + 2, kGyroBias + 2));
  // 50 of 0.01, and a prior of 0.05.
  EXPECT_NEAR(deviation, 0.01 / std::sqrt(50.04), 2e-4);
}

}  // namespace
}  // namespace pipescout::estimation
