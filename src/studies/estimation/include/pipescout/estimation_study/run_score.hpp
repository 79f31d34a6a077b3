// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "pipescout/estimation_study/vehicle_run.hpp"

/// Score of the state estimator on a run.
namespace pipescout::estimation_study {

/// Of the readings of an IMU by its data sheet, for an estimator whose biases walk: white noise and
/// rounding as they are, and a walk that over some 10 s gets as far as flicker noise.
[[nodiscard]] estimation::ImuNoise imu_noise(const simulation::ImuParameters& imu);

/// The estimator's preset for such a vehicle with its known parameters: mounting, antenna, data
/// sheet, gravity, the surveyed rack, the pipe's route.
[[nodiscard]] estimation::StateEstimatorParameters estimator_parameters(const VehicleRun& run,
                                                                        const RunOptions& options);

/// One estimate, taken when a keyframe was new.
struct EstimateScore {
  double time = 0;
  /// Estimate less truth, over the tangent space of a state: position (map), rotation (right),
  /// velocity (map), biases.
  estimation::StateVector error = estimation::StateVector::Zero();
  double way = 0;  ///< m, travelled so far
  /// error^T covariance^-1 error of position, rotation and velocity: 9 on average; and of each. NaN
  /// when not computed, see `ScoreOptions::nees_spacing`.
  double nees = std::numeric_limits<double>::quiet_NaN();
  Eigen::Vector3d nees_parts = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
};

/// Normalised innovation squared of one position (GPS, weld) that is not an outlier: 3 on average.
struct InnovationScore {
  double time = 0;
  double nis = 0;
};

/// Of a requested outage.
struct SilenceScore {
  double way = 0;    ///< m, travelled in it
  double drift = 0;  ///< m, how much the position's error changed; NaN without estimates
};

struct ScoreOptions {
  double settling = 20;      ///< s after the first estimate in the map, that do not count
  double nees_spacing = 1;   ///< s between estimates of which the NEES is computed
  double captured_at = 0.2;  ///< share of a trap's offset: closer to the trap counts as captured
};

/// A stretch of time in which readings of a sensor were refused, one after the other.
struct RefusalScore {
  std::size_t count = 0;  ///< readings, in all
  double longest = 0;     ///< s, from the first to the last of a stretch
};

struct RunScore {
  double started = std::numeric_limits<double>::quiet_NaN();  ///< s, first estimate in the map
  std::vector<EstimateScore> estimates{};                     ///< that count
  std::vector<InnovationScore> innovations{};
  std::vector<SilenceScore> silences{};
  /// Traps in which, or within 30 s of which, the estimate was off by more than
  /// `1 - captured_at` of the trap's offset.
  std::size_t false_reacquisitions = 0;
  std::array<RefusalScore, kSensors> refusals{};  ///< by Sensor, after the start and settling
  /// s, in which GPS fixes that were right were gated or held while the status said that GPS is
  /// trusted or absent: nobody was told.
  double lockout = 0;
  estimation::EstimatorStatus status{};  ///< at the end

  /// Share of the times for which NEES was computed at which the true position was within the
  /// stated 95 % ellipsoid; NaN without any.
  [[nodiscard]] double position_coverage() const;
  [[nodiscard]] double position_rmse() const;           ///< m
  [[nodiscard]] double rotation_rmse() const;           ///< rad
  [[nodiscard]] double velocity_rmse() const;           ///< m/s
  [[nodiscard]] double largest_position_error() const;  ///< m
};

/// Feeds the events in the order of their arrival.
[[nodiscard]] RunScore score_run(const VehicleRun& run, const RunOptions& options,
                                 const estimation::StateEstimatorParameters& parameters,
                                 const ScoreOptions& score = {});

/// Whether averages over runs are those of a consistent estimator.
struct Consistency {
  double nees = 0;  ///< mean over all runs and times, of 9
  double nis = 0;   ///< mean over all runs and times, of 3
  /// Of the times at which the mean over runs is within its two-sided 95 % bounds (chi-square).
  double nees_share = 0;
  double nees_below = 0;  ///< share below the bounds: conservative
  double nis_share = 0;
};
[[nodiscard]] Consistency consistency(std::span<const RunScore> runs);

}  // namespace pipescout::estimation_study
