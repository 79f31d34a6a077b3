// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_world/plant_drive.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

constexpr double kLeastSpeed = 1e-4;  ///< m/s, of which a curvature can be told
constexpr double kStandSpeed = 5e-3;  ///< m/s, that the drive takes for none

const PlantDriveParameters& checked_drive(const PlantDriveParameters& parameters) {
  parameters.validate();
  return parameters;
}

PlantYard yard_of(const PlantDriveParameters& parameters) {
  PlantYard yard(parameters.yard, parameters.seed);
  for (const YardBox& box : parameters.obstacles) {
    yard.add_unmapped(box);
  }
  return yard;
}

}  // namespace

void PlantDriveParameters::validate() const {
  yard.validate();
  vehicle.validate();
  lidar.validate();
  validation::check_above("front", front, 0, 10);
  validation::check_within("rear", rear, 0, 10);
  validation::check_above("width", width, 0, 10);
  validation::check_within("lidar_forward", lidar_forward, -10, 10);
  validation::check_above("watchdog", watchdog, 0, 10);
}

PlantDrive::PlantDrive(const PlantDriveParameters& parameters)
    : parameters_(checked_drive(parameters)),
      yard_(yard_of(parameters)),
      vehicle_(parameters.vehicle, {}),
      pose_(parameters.start) {
  least_clearance_ = yard_.clearance(body());
  if (!(least_clearance_ > 0)) {
    validation::refuse("start: (", pose_.x(), ", ", pose_.y(), ") is in an obstacle");
  }
}

YardBox PlantDrive::body() const {
  const double middle = (parameters_.front - parameters_.rear) / 2;
  return {.centre = {pose_.x() + middle * std::cos(pose_.z()),
                     pose_.y() + middle * std::sin(pose_.z())},
          .heading = pose_.z(),
          .half_length = (parameters_.front + parameters_.rear) / 2,
          .half_width = parameters_.width / 2};
}

void PlantDrive::command(double speed, double yaw_rate) {
  commanded_at_ = steps_;
  if (!std::isfinite(speed) || !std::isfinite(yaw_rate)) {
    vehicle_.command(0, steering_);
    return;
  }
  if (std::abs(speed) > kLeastSpeed) {
    steering_ = std::atan(parameters_.vehicle.wheel_base * yaw_rate / speed);
  }
  vehicle_.command(std::abs(speed) < kStandSpeed ? 0 : speed, steering_);
}

const AckermannState& PlantDrive::drive(int milliseconds) {
  for (int i = 0; i < milliseconds; ++i) {
    if (static_cast<double>(steps_ - commanded_at_) * AckermannVehicle::kStep >
        parameters_.watchdog) {
      vehicle_.command(0, steering_);
    }
    vehicle_.step();
    ++steps_;
    driven_ += std::abs(vehicle_.state().speed) * AckermannVehicle::kStep;
  }
  return vehicle_.state();
}

void PlantDrive::move_to(const Eigen::Vector3d& pose, double dt) {
  pose_ = pose;
  const YardBox now = body();
  yard_.step(dt, now);
  const double clearance = yard_.clearance(now);
  least_clearance_ = std::min(least_clearance_, clearance);
  contact_time_ += clearance <= 0 ? dt : 0;
}

void PlantDrive::scan(std::vector<float>& ranges) const {
  yard_.scan(parameters_.lidar,
             {pose_.x() + parameters_.lidar_forward * std::cos(pose_.z()),
              pose_.y() + parameters_.lidar_forward * std::sin(pose_.z())},
             pose_.z(), parameters_.seed + static_cast<std::uint64_t>(steps_), ranges);
}

}  // namespace pipescout::simulation
