// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

/// A real lawnmower with wheel odometry, a gyro, and RTK-GPS as reference: "Plaza1" and "Plaza2" of
/// Djugash, 2010, "Geolocation with range: robustness, efficiency and scalability", as the data
/// sets lawnmower_plaza1 and lawnmower_plaza2 have them.
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
  /// rad/s, mean turn of the mower that stands at the beginning, and the sum of the steps less it:
  /// what knowing the gyro's bias from the standstill exactly, and no more, comes to.
  double standing_rate = 0;
  DeadReckoningScore less_standing{};
  /// rad/s, the constant bias with which the sum of the steps is nearest to the reference, which
  /// only the reference can tell, and that sum.
  double best_rate = 0;
  DeadReckoningScore less_best{};
  double covered_share = 0;  ///< of the time, the reference within the estimator's 95 % ellipse
};

/// Dead reckoning by the state estimator with the steps only (time, m, rad per row), from the first
/// pose of the reference (time, x, y, heading per row, one header line). The steps are converted to
/// an IMU on level ground and an odometer. Throws std::runtime_error naming the file and line.
/// `reference_heading`: whether that of the reference points forwards (Plaza1) or backwards
/// (Plaza2).
enum class ReferenceHeading : std::uint8_t { kForwards, kBackwards };
[[nodiscard]] LawnmowerScore score_lawnmower(std::string_view steps, std::string_view reference,
                                             ReferenceHeading reference_heading);

}  // namespace pipescout::estimation_study
