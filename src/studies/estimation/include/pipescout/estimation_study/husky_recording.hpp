// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/estimation_study/vehicle_run.hpp"

/// A real ground robot outdoors, with an IMU, wheel odometry and single-point GPS, and without a
/// reference: the Husky of the tests of robot_localization (Charles River Analytics), as the CSV
/// files of the data set husky_outdoor.
namespace pipescout::estimation_study {

/// The contents of the files of these names.
struct HuskyFiles {
  std::string_view imu;   ///< husky_imu.csv: t, quaternion, angular rate, specific force
  std::string_view odom;  ///< husky_odom.csv: t, x, y, qz, qw, vx, vy, wz
  std::string_view fix;   ///< husky_fix.csv: t, status, degrees, degrees, m, variances in m^2
};

/// The map's origin is the first fix.
struct HuskyRecording {
  std::vector<Event> events{};  ///< in the order of time
  double end = 0;               ///< s
};

/// Throws std::runtime_error naming the file and line.
[[nodiscard]] HuskyRecording read_husky(const HuskyFiles& files);

/// The preset of a ground robot, with the IMU mounted as the recording says; nothing is tuned.
[[nodiscard]] estimation::StateEstimatorParameters husky_parameters();

/// Horizontal distances of the estimate from the fixes, each before it was used, m: there is no
/// other reference.
struct HuskyScore {
  double rms = 0;
  double largest = 0;
  double started = 0;        ///< s after the first fix
  std::size_t compared = 0;  ///< fixes
  std::size_t held_out = 0;  ///< fixes that were gated, or held while the source was not trusted,
                             ///< after the start
};
[[nodiscard]] HuskyScore score_husky(const HuskyRecording& husky);

/// The same with the fixes of [begin, begin + duration) withheld: the distance of the estimate from
/// the last of them, m; none when it had no state.
[[nodiscard]] std::optional<double> score_husky_outage(const HuskyRecording& husky, double begin,
                                                       double duration);

}  // namespace pipescout::estimation_study
