// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// What the world is like in ways that a robot is not told of: truth for an estimator to disagree
/// with.
namespace pipescout::simulation {

/// The least and the most of a quantity.
struct Range {
  double least = 0;
  double most = 0;
};

/// All draws are uniform in their range, that of `imu_noise` in its logarithm.
struct WorldRanges {
  Range gps_correlation_time{0, 60};   ///< s, within [0.01, 1e5] but for a least of 0
  Range gps_correlated_share{0, 0.8};  ///< of the variance of GPS: multipath; within [0, 1]
  Range imu_noise{0.5, 2};             ///< factor on what is told; within [0.01, 100]
  Range stamp_offset{-0.05, 0.05};     ///< s, of GPS, odometer and camera each; within [-1, 1]
  Range wheel_scale{-0.02, 0.02};      ///< common to all wheels; within [-0.2, 0.2]
  Range slip{1, 3};                    ///< factor on how often wheels slip; within [0.01, 100]
  Range side_slip{0.01, 0.1};          ///< s, see GroundRobotParameters; within [0, 1]
  Range heights_missing{0, 0.5};       ///< share of the time; within [0, 1]
  Range lost{0, 0.03};                 ///< share of each sensor's data, in bursts; within [0, 0.9]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct World {
  double gps_correlation_time = 0.01;  ///< s
  double gps_correlated_share = 0;     ///< of the variance
  double imu_noise = 1;                ///< factor
  double gps_stamp_offset = 0;         ///< s, stamp less true time
  double odometer_stamp_offset = 0;    ///< s
  double camera_stamp_offset = 0;      ///< s
  double wheel_scale = 0;              ///< relative excess of the reading
  double slip = 1;                     ///< factor
  double side_slip = 0.01;             ///< s
  double heights_missing = 0;          ///< share of the time
  double lost = 0;                     ///< share
};

/// The same seed gives the same world. Throws as WorldRanges::validate.
[[nodiscard]] World draw_world(const WorldRanges& ranges, std::uint64_t seed);

}  // namespace pipescout::simulation
