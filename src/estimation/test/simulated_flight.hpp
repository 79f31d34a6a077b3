// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "pipescout/estimation/fixed_lag_smoother.hpp"

namespace pipescout::estimation::test {

/// A body that flies loops with smooth changes of its attitude, and noisy sensors on it, all from
/// one seed. The IMU runs at 100 Hz, keyframes are at 10 Hz.
struct SimulatedFlight {
  static constexpr double kStep = 0.1;  // s, between keyframes
  static constexpr int kImuPerKeyframe = 10;
  static constexpr double kPositionNoise = 0.2;  // m, GPS
  static constexpr double kPoseNoise = 0.05;     // m, vision
  static constexpr double kAngleNoise = 0.01;    // rad, vision
  static constexpr double kMoveNoise = 0.002;    // m, odometry
  static constexpr double kTurnNoise = 0.001;    // rad, odometry

  SimulatedFlight(std::uint64_t seed, int keyframes, const GlobalStates& true_globals = {});

  std::vector<NavState> truth;                    // at keyframes
  std::vector<ImuSample> imu;                     // kImuPerKeyframe from each but the last
  std::vector<GpsMeasurement> gps;                // one a keyframe
  std::vector<VisualPoseMeasurement> vision;      // one a keyframe
  std::vector<RelativePoseMeasurement> odometry;  // one a keyframe, to it; the first is empty
  NavState first;                                 // a draw around truth[0]
  StateMatrix first_covariance;

  /// Feeds the measurements of one keyframe, IMU first, and updates.
  const UpdateReport& feed(FixedLagSmoother& smoother, int keyframe, bool with_gps,
                           bool with_vision, bool with_odometry) const;
  static double time_of(int keyframe) { return kStep * keyframe; }
};

/// Noise of the IMU of a SimulatedFlight; no gates.
[[nodiscard]] FixedLagSmootherParameters flight_parameters();

}  // namespace pipescout::estimation::test
