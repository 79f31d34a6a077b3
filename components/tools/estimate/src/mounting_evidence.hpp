// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/geometry/so3.hpp"
#include "recording.hpp"

namespace pipescout::estimate {

inline constexpr double kDegree = std::numbers::pi / 180;  // rad

enum class Gravity {
  kMeasured,  ///< the mean specific force is that of gravity
  kUnitG,     ///< it is 1: the readings are in g
  kRemoved,   ///< there is none: the driver has subtracted it
  kUnclear,   ///< anything else
};

/// What a recording shows of the mounting of an IMU, without the state estimator.
struct MountingEvidence {
  Gravity gravity = Gravity::kUnclear;
  double mean_force = 0;  ///< m/s^2, norm of the median specific force
  double tilt = 0;        ///< rad, of the measured vertical from that of the assumed mounting
  /// Yaw rates of gyro and odometer: correlation and factor gyro / odometer. Nothing if the vehicle
  /// turned too little.
  std::optional<double> rate_correlation{};
  double rate_factor = 0;
  /// A sentence, if they turn in opposite directions. GPS may tell which of them is wrong.
  std::string opposite_rates{};
  /// s by which the odometer's yaw rate is behind the gyro's; with a strong correlation only.
  std::optional<double> odometer_delay{};
  /// Correlation of accelerations of odometer and IMU in the plane, at the best yaw, and the number
  /// of intervals; the halves of the recording differ by `yaw_spread` rad.
  double acceleration_correlation = 0;
  std::size_t intervals = 0;
  double yaw_spread = 0;
  bool acceleration_is_clear = false;  ///< both suffice to judge the yaw of the mounting
  /// The mounting that explains both, when the evidence is strong.
  std::optional<geometry::SO3> R_body_imu{};

  /// Sentences: what was found and what to do. Empty when everything agrees with `assumed`.
  std::vector<std::string> findings{};
};

/// Compares the IMU with gravity and with the motion of the odometer (may be null), for an assumed
/// mounting. Needs no start value. An advice is given only when two halves of the recording agree.
[[nodiscard]] MountingEvidence examine_mounting(const Stream& imu, const Stream* odometer,
                                                const geometry::SO3& assumed);

}  // namespace pipescout::estimate
