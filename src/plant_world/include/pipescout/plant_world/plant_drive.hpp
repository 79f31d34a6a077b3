// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <pipescout/simulation/ackermann_vehicle.hpp>
#include <pipescout/simulation/plant_yard.hpp>
#include <vector>

namespace pipescout::simulation {

struct PlantDriveParameters {
  PlantYardParameters yard{};
  std::vector<YardBox> obstacles{};  ///< further ones that the map does not show
  AckermannVehicleParameters vehicle{};
  Eigen::Vector3d start{-3.5, 3.25, 0};  ///< m, m, rad, in the map: of the rear axle
  LidarParameters lidar{};
  double front = 1.55;         ///< m, of the body before the rear axle, (0, 10]
  double rear = 0.35;          ///< m, behind it, [0, 10]
  double width = 1;            ///< m, (0, 10]
  double lidar_forward = 0.8;  ///< m, before the rear axle, [-10, 10]
  double watchdog = 0.5;       ///< s, (0, 10]: without a command the vehicle stops
  std::uint64_t seed = 1;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The drive of a vehicle with Ackermann steering that is given twists, and the plant around it:
/// lidar, and whether the body touches anything. Where the vehicle is, is told from outside, for
/// example from a robot on rough ground. Pure; the same parameters and calls give the same bits.
/// Not thread-safe.
class PlantDrive {
 public:
  /// Throws as PlantDriveParameters::validate; std::invalid_argument for a start in an obstacle.
  explicit PlantDrive(const PlantDriveParameters& parameters);

  /// m/s forwards, and rad/s: as a driver of such a vehicle takes a twist, whose ratio is the
  /// curvature. Without a speed the wheels stay as they are. What is not finite is a stop.
  void command(double speed, double yaw_rate);
  /// Steering and wheels after that many ms; its position is that on flat ground.
  const AckermannState& drive(int milliseconds);
  /// The rear axle is at x, y and heads to `pose.z()`, m, m and rad, `dt` s after the last call.
  void move_to(const Eigen::Vector3d& pose, double dt);

  /// Of a lidar that looks all around, from the last pose.
  void scan(std::vector<float>& ranges) const;
  /// s, for which the body overlapped anything.
  [[nodiscard]] double contact_time() const { return contact_time_; }
  [[nodiscard]] double least_clearance() const { return least_clearance_; }  ///< m
  [[nodiscard]] double driven() const { return driven_; }                    ///< m, both ways
  [[nodiscard]] const PlantYard& yard() const { return yard_; }
  [[nodiscard]] const PlantDriveParameters& parameters() const { return parameters_; }

 private:
  [[nodiscard]] YardBox body() const;

  PlantDriveParameters parameters_;
  PlantYard yard_;
  AckermannVehicle vehicle_;
  Eigen::Vector3d pose_;
  std::int64_t steps_ = 0;
  std::int64_t commanded_at_ = 0;
  double steering_ = 0;  ///< rad, commanded
  double contact_time_ = 0;
  double least_clearance_ = 0;
  double driven_ = 0;
};

}  // namespace pipescout::simulation
