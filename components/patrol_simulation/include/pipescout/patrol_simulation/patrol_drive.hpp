// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <pipescout/simulation/gps_receiver.hpp>
#include <pipescout/simulation/imu_sensor.hpp>
#include <pipescout/simulation/thermal_patrol.hpp>
#include <vector>

namespace pipescout {

struct PatrolDriveParameters {
  simulation::ThermalPatrolParameters patrol{};
  double standing = 5;  ///< s, [0, 1000]: before it drives, so that an estimator can begin
  /// At the origin of the body, with its axes; its period is rounded to steps of the robot.
  simulation::ImuParameters imu = simulation::ImuParameters::industrial();
  simulation::GpsParameters gps{};
  double odometer_period = 0.02;  ///< s, [0.002, 10]: rounded likewise
  std::uint64_t seed = 1;         ///< of the sensors

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A robot on patrol, and what its sensors say. Pure; the same parameters give the same bits. Not
/// thread-safe.
class PatrolDrive {
 public:
  /// Throws as PatrolDriveParameters::validate.
  explicit PatrolDrive(const PatrolDriveParameters& parameters);

  struct ImuSample {
    double time = 0;
    simulation::ImuReading reading{};
  };
  struct OdometerSample {
    double time = 0;
    std::array<double, simulation::kWheels> distances{};  ///< m
  };

  /// Drives on to a time, s from the start, to the nearest step; nothing for one that has passed.
  void drive_until(double time);
  /// What the sensors have said since the last call: by time; fixes of GPS by their arrival, those
  /// that have arrived.
  [[nodiscard]] std::vector<ImuSample> take_imu_samples();
  [[nodiscard]] std::vector<OdometerSample> take_odometer_samples();
  [[nodiscard]] std::vector<simulation::GpsFix> take_fixes();

  [[nodiscard]] const simulation::BodyMotion& motion() const noexcept {
    return patrol_.robot().motion();
  }
  /// At the end of its way, after the camera has passed the tube.
  [[nodiscard]] bool arrived() const noexcept { return patrol_.arrived(); }
  [[nodiscard]] simulation::ThermalPatrol& patrol() noexcept { return patrol_; }
  [[nodiscard]] const simulation::ThermalPatrol& patrol() const noexcept { return patrol_; }

 private:
  void measure();

  PatrolDriveParameters parameters_;
  simulation::ThermalPatrol patrol_;
  simulation::ImuSensor imu_;
  simulation::GpsReceiver gps_;
  std::int64_t steps_ = 0;
  std::int64_t steps_per_imu_sample_;
  std::int64_t steps_per_odometer_sample_;
  std::vector<ImuSample> imu_samples_;
  std::vector<OdometerSample> odometer_samples_;
  std::vector<simulation::GpsFix> fixes_;  // on their way
};

}  // namespace pipescout
