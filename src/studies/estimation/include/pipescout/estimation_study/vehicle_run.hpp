// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/simulation/gps_receiver.hpp"
#include "pipescout/simulation/imu_sensor.hpp"
#include "pipescout/simulation/world.hpp"

/// Runs of the three kinds of robot: sensor data in the order of arrival, with ground truth. SI
/// units, rad; seconds from the beginning of a run. Frames: `map` (z up), `body` (the vehicle's
/// axes, origin at the IMU), `rack`.
namespace pipescout::estimation_study {

enum class Vehicle : std::uint8_t {
  kGroundRobot,  ///< IMU, GPS, odometer of four wheels; stands for 5 s, then drives cross-country
  kUav,          ///< IMU, GPS, and visual poses over a rack; stands for 5 s, flies there, stays
  kCrawler,      ///< IMU, odometer of three wheels, welds; stands for 5 s in a pipe of known course
};

enum class Sensor : std::uint8_t { kImu, kOdometer, kGps, kVisualPose, kWeld };
inline constexpr std::size_t kSensors = 5;

/// Outage of a sensor in [begin, begin + duration).
struct Silence {
  Sensor sensor = Sensor::kGps;
  double begin = 0;
  double duration = 0;
};

enum class GpsGrade : std::uint8_t {
  kRtk,         ///< fixed carrier phases: 1.2 cm level, 2.4 cm up; a third of the square correlated
                ///< over 20 s
  kStandalone,  ///< 0.64 m level, 1.3 m up; three fifths of the square correlated over 60 s
};

struct RunOptions {
  double duration = 180;  ///< s, (20, 3600]
  simulation::ImuParameters imu = simulation::ImuParameters::industrial();
  GpsGrade gps = GpsGrade::kRtk;
  /// Whether part of the error of GPS is that of multipath, correlated in time, of which the stated
  /// covariance says nothing; or all of it, of the same size, is white.
  bool correlated_gps = false;
  std::vector<Silence> silences{};
  /// This sensor has gross outliers in `outlier_share` of its readings: the IMU by up to 5 g and 5
  /// rad/s, the odometer by 1 to 10 m, GPS by 10 to 100 m, visual poses by 0.3 to 3 m and up to 0.5
  /// rad, welds by a joint or more. Outliers are not marked in the readings.
  std::optional<Sensor> outliers{};
  double outlier_share = 0.2;
  std::vector<simulation::GpsTrap> traps{};
  /// What is as it is drawn, not as it is told; the options above are what is told. GPS of the
  /// given grade is correlated as drawn, whatever `correlated_gps` says.
  std::optional<simulation::World> world{};
  bool in_flight = false;  ///< the UAV hovers in the wind at the beginning, instead of standing

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

using Reading = std::variant<estimation::ImuReading, estimation::OdometerReading,
                             estimation::GpsMeasurement, estimation::VisualPoseMeasurement,
                             estimation::WeldMeasurement, estimation::GivenPose>;

[[nodiscard]] double time_of(const Reading& reading);

struct Event {
  double arrival = 0;
  Reading reading{};
  bool wrong = false;  ///< the truth about it: an outlier or a trap
};

struct TruthPoint {
  double time = 0;
  estimation::NavState state{};  ///< biases too, in the axes of the body
  double way = 0;                ///< m, path so far in either direction
};

/// A run. Members after the truth are known parameters of the vehicle.
struct VehicleRun {
  Vehicle vehicle = Vehicle::kGroundRobot;
  std::vector<Event> events{};      ///< by arrival
  std::vector<TruthPoint> truth{};  ///< 100 Hz, from 0 on
  geometry::SO3 R_body_imu{};
  Eigen::Vector3d antenna = Eigen::Vector3d::Zero();  ///< m, in the body
  /// m, in the body: point whose path the odometer measures.
  Eigen::Vector3d odometer_point = Eigen::Vector3d::Zero();
  geometry::SE3 T_map_rack{};  ///< the truth about it, of a run with a rack
  /// As surveyed, off by `rack_position_deviation` (m) and `rack_rotation_deviation` (rad) per
  /// axis.
  geometry::SE3 T_map_rack_surveyed{};
  double rack_position_deviation = 0;
  double rack_rotation_deviation = 0;
  std::vector<Eigen::Vector3d> route{};  ///< m, polyline of a pipe; otherwise empty
  double route_deviation = 0;            ///< m per axis, of the body from the route
  double route_correlation = 0;          ///< m, correlation length of it
  /// rad per axis, of the body's x axis from its travel; same correlation length
  double crab_deviation = 0;
  std::vector<double> tally{};          ///< m, chainages of all welds on the route, to 0.01 m
  double odometer_scale_deviation = 0;  ///< from the tolerance of its wheels
};

/// The same options and seed give the same bits; an option does not change the random numbers of
/// the others. Throws as RunOptions::validate.
[[nodiscard]] VehicleRun ground_robot_run(const RunOptions& options, std::uint64_t seed);
[[nodiscard]] VehicleRun uav_run(const RunOptions& options, std::uint64_t seed);
[[nodiscard]] VehicleRun crawler_run(const RunOptions& options, std::uint64_t seed);
[[nodiscard]] VehicleRun vehicle_run(Vehicle vehicle, const RunOptions& options,
                                     std::uint64_t seed);

/// The true state at a time, between two points by their mean; of the ends beyond them.
[[nodiscard]] estimation::NavState truth_at(const VehicleRun& run, double time);
/// m, gone until then.
[[nodiscard]] double way_at(const VehicleRun& run, double time);

}  // namespace pipescout::estimation_study
