// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "pipescout/estimation_study/vehicle_run.hpp"
#include "pipescout/simulation/body_motion.hpp"
#include "pipescout/statistics/draw.hpp"

/// What the runs have in common: from the motion of a body to readings.
namespace pipescout::estimation_study::internal {

using statistics::Draw;

/// Draws of a run that have nothing to do with those of the simulators, which are given the same
/// seed; one for each purpose.
[[nodiscard]] Draw make_draw(std::uint64_t seed, std::uint64_t purpose);

class Recorder {
 public:
  /// `run` is to have its vehicle, mounting and antenna.
  Recorder(const RunOptions& options, VehicleRun& run, std::uint64_t seed);

  /// To be called at each multiple of a millisecond at which the sensors may be due, in order.
  /// `body`: of the IMU's place, in the vehicle's axes. `way`: m, gone so far.
  void sample(const simulation::BodyMotion& body, double way);
  /// The reading of the IMU that `sample` has just taken, if it has, in the vehicle's axes.
  [[nodiscard]] const std::optional<estimation::ImuReading>& newest_imu() const noexcept {
    return newest_imu_;
  }
  void odometer(const estimation::OdometerReading& reading, double arrival);
  /// Of a body at this pose in the rack.
  void visual_pose(double time, const geometry::SE3& T_rack_body);
  /// `joint` m long: how far a wrong one is off at least.
  void weld(const estimation::WeldMeasurement& m, double arrival, double joint);
  void given(const estimation::GivenPose& pose);
  [[nodiscard]] bool silent(Sensor sensor, double time) const;
  /// Sorts the events: to be called at the end.
  void finish();

 private:
  void push(double arrival, const Reading& reading, bool wrong);
  [[nodiscard]] bool wrong(Sensor sensor, Draw& draw) const;

  const RunOptions& options_;
  VehicleRun& run_;
  simulation::ImuSensor imu_;
  simulation::GpsReceiver gps_;
  Draw imu_draw_;
  Draw odometer_draw_;
  Draw vision_draw_;
  Draw weld_draw_;
  std::uint64_t imu_samples_ = 0;
  std::optional<estimation::ImuReading> newest_imu_{};
  Eigen::Vector3d last_rate_ =
      Eigen::Vector3d::Zero();  // rad/s, of the last reading, the same axes
};

}  // namespace pipescout::estimation_study::internal
