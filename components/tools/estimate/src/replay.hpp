// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "configuration.hpp"
#include "further_inputs.hpp"
#include "gps_evidence.hpp"
#include "mounting_evidence.hpp"
#include "pipescout/estimation/state_estimator.hpp"
#include "recording.hpp"

namespace pipescout::estimate {

struct TrajectoryPoint {
  double time = 0;                                     ///< s since Recording::origin
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, in the map
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();            ///< m/s, in the map
  Eigen::Vector3d position_deviation = Eigen::Vector3d::Zero();  ///< m
};

/// A time in which GPS was there and not used.
struct HeldOut {
  double begin = 0;
  double end = 0;
  double farthest = 0;  ///< m, between GPS and the state
  std::size_t fixes = 0;
};

/// A change of what the estimator believes.
struct Change {
  double time = 0;
  std::string what;
};

struct Trajectory {
  bool with_imu = false;          ///< false: from wheels (and GPS) alone, planar
  std::vector<std::string> said;  ///< how the sources were used: frames, mounting, covariances
  std::vector<TrajectoryPoint> points;
  std::vector<ComparedFix> fixes;
  std::vector<HeldOut> held;
  std::vector<Change> changes;
  estimation::EstimatorStatus status{};
  estimation::CorrelationFinding gps_correlation{};
  std::optional<geometry::GeodeticPosition> datum{};  ///< of the map; nothing without GPS
  std::vector<FurtherOutcome> further;
  MountingEvidence mounting{};
  GpsEvidence track{};
  double recorded_until = 0;       ///< s, of the newest measurement
  double started = 0;              ///< s, of the first pose in the map; before it: dead reckoning
  double odometer_scale = 1;       ///< as estimated
  double gps_delay = 0;            ///< s, by how much later than its stamp a fix was measured
  double gps_delay_deviation = 0;  ///< s
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();           ///< rad/s, at the end
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< m/s^2, at the end
};

/// Runs the estimator over the recording. `apply_mounting`: with the mounting that the motion
/// shows, if the evidence is strong. Throws std::invalid_argument, with a sentence for the user,
/// when the configuration names sources that are not there or do not suffice.
[[nodiscard]] Trajectory estimate_trajectory(const Recording& recording,
                                             const Configuration& configuration,
                                             bool apply_mounting, const Progress& progress);

}  // namespace pipescout::estimate
