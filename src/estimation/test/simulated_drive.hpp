// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "pipescout/estimation/fixed_lag_smoother.hpp"

namespace pipescout::estimation::test {

/// A ground robot that drives a winding course at changing speed, with a wheel away from the IMU,
/// an antenna that is stamped late, and a camera over a rack, all from one seed. The IMU runs at
/// 100 Hz, keyframes are at 10 Hz.
struct SimulatedDrive {
  static constexpr double kStep = 0.1;  // s, between keyframes
  static constexpr int kImuPerKeyframe = 10;
  static constexpr double kPositionNoise = 0.05;  // m, GPS
  static constexpr double kPoseNoise = 0.05;      // m, vision
  static constexpr double kAngleNoise = 0.01;     // rad, vision
  static constexpr double kDistanceNoise = 1e-3;  // m, odometer
  static constexpr double kSlip = 2e-3;           // m, odometer, across
  static constexpr double kSideways = 0.02;       // m/s, non-holonomic

  /// The time offset of the GPS must be a multiple of 0.01 s and not negative. `wheel` in the body.
  SimulatedDrive(std::uint64_t seed, int keyframes, const GlobalStates& true_globals,
                 const Eigen::Vector3d& wheel);

  std::vector<NavState> truth;                         // at keyframes
  std::vector<ImuSample> imu;                          // kImuPerKeyframe from each but the last
  std::vector<GpsMeasurement> gps;                     // one a keyframe
  std::vector<VisualPoseMeasurement> vision;           // one a keyframe
  std::vector<NonHolonomicMeasurement> non_holonomic;  // one a keyframe
  std::vector<OdometerMeasurement> odometer;           // one a keyframe, to it; the first is empty
  NavState first;                                      // a draw around truth[0]
  StateMatrix first_covariance;

  static double time_of(int keyframe) { return kStep * keyframe; }
};

/// Noise of the IMU of a SimulatedDrive; no gates.
[[nodiscard]] FixedLagSmootherParameters drive_parameters();

/// Of an IMU whose gyro has a scale factor of 1 % off about z and 0.5 % off about the other axes,
/// and axes in either triad that are 3 to 6 mrad off.
[[nodiscard]] ImuScale wrong_scale();

}  // namespace pipescout::estimation::test
