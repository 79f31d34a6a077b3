// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

/// A real lawnmower with wheel odometry, a gyro, and RTK-GPS as reference: "Plaza2" of Djugash,
/// 2010, "Geolocation with range: robustness, efficiency and scalability", as the data set
/// lawnmower_plaza2 has it.
namespace pipescout::estimation_study {

/// Distances from the reference, m.
struct DeadReckoningScore {
  double rms = 0;
  double largest = 0;
  double end = 0;
};

struct LawnmowerScore {
  double way = 0;                  ///< m
  DeadReckoningScore estimator{};  ///< gyro bias estimated at the initial standstill
  DeadReckoningScore summed{};     ///< sum of the steps alone
  double covered_share = 0;  ///< of the time, the reference within the estimator's 95 % ellipse
};

/// Dead reckoning by the state estimator with the steps only (time, m, rad per row), from the first
/// pose of the reference (time, x, y, heading per row, one header line). The steps are converted to
/// an IMU on level ground and an odometer. Throws std::runtime_error naming the file and line.
[[nodiscard]] LawnmowerScore score_lawnmower(std::string_view steps, std::string_view reference);

}  // namespace pipescout::estimation_study
