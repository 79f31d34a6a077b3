// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipescout/odometry/odometer_stream.hpp"

/// A crawler with wheels around the circumference drives through one bend. The fusion is told the
/// nominal clock positions, noise and scales; the truth has clock positions and scales that are
/// off, wheels that are not in one plane, a crawler that rolls and changes its speed, in the bend
/// too, and wheels that slip.
namespace pipescout::odometry_study {

struct ElbowSettings {
  odometry::FusionRule rule = odometry::FusionRule::kCircumference;
  std::size_t wheels = 3;
  double pipe_diameter = 1.0;  ///< m, inner
  // The bend.
  double tightest = 1.5;  ///< pipe diameters, radius of the axis, uniform
  double widest = 5.0;
  double standard_share = 0.6;  ///< of bends of 90 degrees; the others 20 to 90
  // The crawler.
  double wheel_noise = 0.004;    ///< m per square root of a metre, each wheel
  double scale_error = 0.0005;   ///< standard deviation, each wheel: calibrated ones
  double clock_error = 0.0175;   ///< rad, standard deviation
  double out_of_plane = 0.02;    ///< m, along the axis, standard deviation
  double roll_per_metre = 0.01;  ///< rad, standard deviation
  double speed_spread = 0.03;    ///< largest relative change from its mean, every few metres
  double slows_share = 0.5;      ///< of the crawlers: slower in bends
  double slowest_in_bend = 0.7;  ///< share of the speed, uniform up to 1
  double slip_every = 50.0;      ///< m, on average, one wheel at a time; 0: none
  double slip_longest = 5.0;     ///< m, above 0.5
  double slip_most = 0.3;        ///< largest share that is lost
  bool slips_in_bends = false;   ///< none within 3 m of the bend otherwise
  std::size_t slip_in_bend = 0;  ///< bursts that lie in the bend, in addition
};

struct ElbowScore {
  double error = 0.0;  ///< m, of the distance from 0.5 m before the bend to two windows behind it
  double standard_deviation = 0.0;  ///< m, as stated
  /// One bend found, with its middle within half its length or a window, and its angle within 10
  /// degrees.
  bool found = false;
  double angle_error = 0.0;   ///< rad, if found
  double middle_error = 0.0;  ///< m, if found
  std::size_t others = 0;     ///< found bends that are none
  double driven = 0.0;        ///< m
};

/// The same seed gives the same bits. Throws std::invalid_argument as the simulators do.
[[nodiscard]] ElbowScore run_elbow(const ElbowSettings& settings, std::uint64_t seed);

/// Scores of many bends.
struct ElbowScores {
  std::vector<double> errors;  ///< m, absolute
  std::size_t inside = 0;      ///< error within 1.96 stated standard deviations
  std::size_t found = 0;
  std::size_t others = 0;
  double driven = 0.0;  ///< m

  ElbowScores& operator+=(const ElbowScores& other);
};

/// Bends whose seeds are drawn from `seed`.
[[nodiscard]] ElbowScores run_elbows(const ElbowSettings& settings, std::uint64_t seed,
                                     std::size_t count);

}  // namespace pipescout::odometry_study
