// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "recording.hpp"

namespace pipescout::estimate {

/// A usable fix in the map, for comparison.
struct ComparedFix {
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double deviation = 0;  ///< m, as used, horizontal
};

/// What the track of GPS shows of the other sensors, without the state estimator: the third witness
/// where gyro and odometer contradict each other.
struct GpsEvidence {
  /// Way by GPS over way by the odometer; nothing if it was short next to the noise of GPS.
  std::optional<double> way_factor{};
  /// Correlation of the turns of the course with those of gyro and odometer; nothing if the vehicle
  /// turned too little.
  std::optional<double> gyro_correlation{};
  std::optional<double> odometer_correlation{};
  bool gyro_is_opposite = false;      ///< clearly
  bool odometer_is_opposite = false;  ///< its yaw rate, clearly

  /// Sentences: what was found and what to do. Empty when all agree.
  std::vector<std::string> findings{};
};

/// Compares fixes with odometer and IMU (either may be null). `scale`: factor on the odometer's
/// speed; `up`: the vertical in the frame of the IMU, a unit vector.
[[nodiscard]] GpsEvidence examine_gps(const Stream& gps, const std::vector<ComparedFix>& fixes,
                                      const Stream* odometer, double scale, const Stream* imu,
                                      const Eigen::Vector3d& up);

}  // namespace pipescout::estimate
