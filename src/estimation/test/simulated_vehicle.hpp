// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <variant>
#include <vector>

#include "pipescout/estimation/state_estimator.hpp"

namespace pipescout::estimation::test {

using AnyMessage = std::variant<ImuReading, OdometerReading, GpsMeasurement, HeadingMeasurement,
                                VisualPoseMeasurement, WeldMeasurement, GivenPose>;

struct Message {
  double arrival = 0;  // s
  AnyMessage content{};
};

/// What a vehicle is, and what it carries.
struct VehicleOptions {
  enum class Kind { kDrive, kFly } kind = Kind::kDrive;
  double duration = 60;    // s
  double standing = 4;     // s, before it starts
  double speed = 3;        // m/s, about
  double stop_from = 1e9;  // s; it stands still between these
  double stop_until = 1e9;
  double heading = 0;                                      // rad, by which the whole path is turned
  Eigen::Vector3d origin = Eigen::Vector3d(100, -50, 20);  // m, in the map
  bool odometer = true;
  bool gps = true;
  bool compass = false;
  bool vision = false;
  double gps_deviation = 0.5;  // m
  double imu_rate = 100;       // Hz
};

/// A vehicle on a figure of eight over a hill, or in the air, and all its messages in the order of
/// their arrival: IMU at 100 Hz, odometer at 50 Hz, GPS at 5 Hz 50 ms late, visual poses at 10 Hz
/// 30 ms late, compass at 10 Hz. Noise from one seed.
class SimulatedVehicle {
 public:
  SimulatedVehicle(std::uint64_t seed, const VehicleOptions& options);

  [[nodiscard]] const std::vector<Message>& messages() const { return messages_; }
  [[nodiscard]] NavState truth(double time) const;
  [[nodiscard]] const VehicleOptions& options() const { return options_; }

 private:
  [[nodiscard]] double way_parameter(double time) const;
  [[nodiscard]] Eigen::Vector3d place(double time) const;
  [[nodiscard]] geometry::SO3 attitude(double time) const;

  VehicleOptions options_;
  std::vector<Message> messages_;
};

/// Hands over one message; GPS positions and so on as they are.
void deliver(StateEstimator& estimator, const AnyMessage& message);

/// Delivers what arrives in [from, until); `change` may change a message or, by false, drop it.
/// `after` is called after each message with an estimate.
using Change = std::function<bool(AnyMessage&)>;
using After = std::function<void(const Estimate&)>;
void deliver(StateEstimator& estimator, const SimulatedVehicle& vehicle, double from, double until,
             const Change& change = nullptr, const After& after = nullptr);

/// Noise of the IMU of a SimulatedVehicle.
[[nodiscard]] ImuNoise vehicle_imu_noise();

}  // namespace pipescout::estimation::test
