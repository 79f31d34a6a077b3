// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "pipescout/estimation/fixed_lag_smoother.hpp"

/// A rack that comes into view late, and whose pose is hardly known before: global states must be
/// linearised where they are found, whatever else has been marginalised before.
namespace pipescout::estimation_study {

struct LateRackSettings {
  double duration = 50;             ///< s, of the flight
  double seen_from = 25;            ///< s
  double position_deviation = 2;    ///< m, per axis, of the rack's pose beforehand
  double rotation_deviation = 0.5;  ///< rad, per axis
};

/// IMU (industrial grade) at 100 Hz, GPS at 5 Hz and visual poses at 10 Hz, on a course that no
/// model of the estimator knows. The prior is true: the rack's pose is drawn from it.
struct LateRackFlight {
  estimation::FixedLagSmootherParameters parameters{};
  estimation::GlobalStates truth{};
  estimation::NavState first{};
  estimation::StateMatrix first_covariance = estimation::StateMatrix::Zero();
  std::vector<double> times;  ///< s, of keyframes
  std::vector<estimation::ImuSample> imu;
  std::vector<estimation::GpsMeasurement> gps;
  std::vector<estimation::VisualPoseMeasurement> vision;

  /// Fixes, then visual poses, as the batch smoother takes them.
  [[nodiscard]] std::vector<estimation::AnyFactor> measurements() const;
};

[[nodiscard]] LateRackFlight fly_to_late_rack(const LateRackSettings& settings, std::uint64_t seed);

/// Normalised squared error of the rack's pose, expected 6. `covariance`: of all global states.
[[nodiscard]] double rack_nees(
    const estimation::GlobalStates& found, const estimation::GlobalStates& truth,
    const Eigen::Matrix<double, estimation::kGlobalSize, estimation::kGlobalSize>& covariance);

/// Of the rack's pose at the end, by the fixed-lag smoother.
struct LateRackScore {
  double nees = 0;
  double position = 0;        ///< m
  double rotation = 0;        ///< rad
  double accepted_share = 0;  ///< of the visual poses
};
[[nodiscard]] LateRackScore score_late_rack(const LateRackFlight& flight);

}  // namespace pipescout::estimation_study
