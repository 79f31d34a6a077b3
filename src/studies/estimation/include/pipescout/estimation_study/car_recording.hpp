// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>
#include <vector>

#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/estimation_study/vehicle_run.hpp"

/// A real car with wheel speeds, a telephone's IMU and GPS, and a reference: a segment of comma2k19
/// (Schafer, Santana, Haden and Biasini, 2018, "A commute in data: the comma2k19 dataset"), as the
/// CSV files of the data set car_comma2k19.
namespace pipescout::estimation_study {

/// The contents of the files of these names.
struct CarFiles {
  std::string_view accelerometer;  ///< t, forward, right, down: m/s^2
  std::string_view gyro;           ///< t, forward, right, down: rad/s
  std::string_view wheel_speed;    ///< t, four wheels: m/s
  std::string_view gnss;  ///< gnss_ublox_live: t, latitude, longitude, speed, UTC, altitude, ...
  std::string_view reference;  ///< t, week, seconds, position and velocity (geocentric), ...
};

struct CarReference {
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, in the map
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s, in the map
};

/// The map's origin is the first position of the reference.
struct CarRecording {
  std::vector<Event> events{};  ///< in the order of time; no outliers are marked
  std::vector<CarReference> reference{};
  /// Input of dead reckoning: mean of the wheels, and the gyro's rate about up.
  struct Speed {
    double time = 0;
    double speed = 0;  ///< m/s
  };
  struct Turn {
    double time = 0;
    double rate = 0;  ///< rad/s, to the left
  };
  std::vector<Speed> speeds{};
  std::vector<Turn> turns{};
};

/// Throws std::runtime_error naming the file and line.
[[nodiscard]] CarRecording read_car(const CarFiles& files);

/// The preset of a ground robot, changed for a car that is moving when the recording begins: its
/// speed; a telephone behind the windscreen, whose orientation and time offset to the GPS receiver
/// are estimated.
[[nodiscard]] estimation::StateEstimatorParameters car_parameters();

/// Position error after GPS was withheld over [begin, begin + duration). Errors are horizontal,
/// relative to those at `begin`: the receiver and the reference differ by up to 2 m throughout.
struct CarOutage {
  double begin = 0;
  double way = 0;            ///< m, by the reference
  double error = 0;          ///< m, of the estimator at the end; NaN: it had no state
  double dead_reckoned = 0;  ///< m, of wheels and gyro from the reference's place and course
};
[[nodiscard]] CarOutage score_car_outage(const CarRecording& car, double begin, double duration);

/// With GPS throughout.
struct CarScore {
  double started = 0;   ///< s after the beginning; NaN: never
  double position = 0;  ///< m, horizontal, root mean square
  double speed = 0;     ///< m/s, root mean square
  double course = 0;    ///< rad, root mean square
};
[[nodiscard]] CarScore score_car(const CarRecording& car);

}  // namespace pipescout::estimation_study
