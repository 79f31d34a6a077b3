// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <pipescout/plant_world/localisation_errors.hpp>
#include <pipescout/simulation/ackermann_vehicle.hpp>
#include <pipescout/simulation/plant_yard.hpp>
#include <vector>

namespace pipescout {

struct PlantDriveParameters {
  simulation::PlantYardParameters yard{};
  std::vector<simulation::YardBox> obstacles{};  ///< further ones that the map does not show
  simulation::AckermannVehicleParameters vehicle{};
  simulation::AckermannState start{.x = -3.5, .y = 3.25};
  simulation::LidarParameters lidar{};
  simulation::LocalisationErrorParameters localisation{};
  double front = 1.55;         ///< m, of the body before the rear axle, (0, 10]
  double rear = 0.35;          ///< m, behind it, [0, 10]
  double width = 1;            ///< m, (0, 10]
  double lidar_forward = 0.8;  ///< m, before the rear axle, [-10, 10]
  double watchdog = 0.5;       ///< s, (0, 10]: without a command the vehicle stops
  std::uint64_t seed = 1;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A vehicle in a plant, what its sensors say, and whether it touched anything. Pure; the same
/// parameters and commands give the same bits. Not thread-safe.
class PlantDrive {
 public:
  /// Throws as PlantDriveParameters::validate; std::invalid_argument for a start in an obstacle.
  explicit PlantDrive(const PlantDriveParameters& parameters);

  /// m/s forwards, and rad/s: as a driver of such a vehicle takes a twist, whose ratio is the
  /// curvature. Without a speed the wheels stay as they are. What is not finite is a stop.
  void command(double speed, double yaw_rate);
  /// Moves vehicle and obstacles by that many ms.
  void drive(int milliseconds);

  [[nodiscard]] double time() const { return static_cast<double>(steps_) * 1e-3; }
  [[nodiscard]] const simulation::AckermannState& truth() const { return vehicle_.state(); }
  /// Where the localisation says that it is; `dt` s after the last call.
  [[nodiscard]] simulation::AckermannState measured(double dt);
  void scan(std::vector<float>& ranges) const;
  /// m to the pipe at the left; nothing where there is none beside the robot.
  [[nodiscard]] std::optional<double> range_to_pipe() const;
  /// Steps of 1 ms in which the body overlapped anything.
  [[nodiscard]] std::uint64_t collisions() const { return collisions_; }
  [[nodiscard]] double least_clearance() const { return least_clearance_; }
  [[nodiscard]] double driven() const { return driven_; }
  [[nodiscard]] const simulation::PlantYard& yard() const { return yard_; }
  [[nodiscard]] const PlantDriveParameters& parameters() const { return parameters_; }

 private:
  [[nodiscard]] simulation::YardBox body() const;

  PlantDriveParameters parameters_;
  simulation::PlantYard yard_;
  simulation::AckermannVehicle vehicle_;
  simulation::LocalisationErrors errors_;
  std::int64_t steps_ = 0;
  std::int64_t commanded_at_ = 0;
  double steering_ = 0;  ///< rad, commanded
  std::uint64_t collisions_ = 0;
  double least_clearance_ = 0;
  double driven_ = 0;  ///< m
};

}  // namespace pipescout
