// SPDX-License-Identifier: Apache-2.0
#pragma once

/// A drive of 50 km over the ellipsoid: the map is a plane that touches the Earth where it begins.
namespace pipescout::estimation_study {

struct LongDriveSettings {
  double latitude = 55;  ///< degrees, where it begins
  double length = 50e3;  ///< m
  double speed = 25;     ///< m/s
  bool earth = true;     ///< the estimator is told where on the Earth the map is
};

/// Over the last tenth of the way.
struct LongDriveScore {
  double heading = 0;  ///< rad, root mean square
  double tilt = 0;     ///< rad
};

/// IMU at 50 Hz and GPS at 2 Hz, both without errors: what is left is that of the model. The motion
/// and the readings are computed in the frame that turns with the Earth (WGS 84, gravity by
/// Somigliana), and not from the map.
[[nodiscard]] LongDriveScore score_long_drive(const LongDriveSettings& settings);

}  // namespace pipescout::estimation_study
