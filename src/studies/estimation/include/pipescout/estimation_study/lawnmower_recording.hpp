// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

/// A real lawnmower with wheel odometry and a gyro beside RTK-GPS: "Plaza2" of Djugash, 2010,
/// "Geolocation with range: robustness, efficiency and scalability", as the data set
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
  DeadReckoningScore estimator{};  ///< knows its gyro's bias from standing at the beginning
  DeadReckoningScore summed{};     ///< the steps as they are, one after the other
  double covered_share = 0;  ///< of the time, the reference within the estimator's 95 % ellipse
};

/// Dead reckoning by the state estimator with nothing but the steps (time, m, rad a row), from
/// where the reference (time, x, y, heading a row, one line of header) begins. The steps stand in
/// for an IMU on level ground and an odometer. Throws std::runtime_error naming the file and line.
[[nodiscard]] LawnmowerScore score_lawnmower(std::string_view steps, std::string_view reference);

}  // namespace pipescout::estimation_study
