// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_simulation/plant_drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace pipescout {
namespace {

using simulation::AckermannState;
using simulation::AckermannVehicle;
using simulation::YardBox;

constexpr double kLeastSpeed = 1e-4;  ///< m/s, of which a curvature can be told
constexpr double kStandSpeed = 5e-3;  ///< m/s, that the drive takes for none
constexpr double kMillisecond = 1e-3;

void check(const char* field, double value, bool in_range, const char* range) {
  if (!in_range) {
    throw std::invalid_argument(std::string(field) + ": " + std::to_string(value) + " is outside " +
                                range);
  }
}

const PlantDriveParameters& checked(const PlantDriveParameters& parameters) {
  parameters.validate();
  return parameters;
}

simulation::PlantYard yard_of(const PlantDriveParameters& parameters) {
  simulation::PlantYard yard(parameters.yard, parameters.seed);
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
  localisation.validate();
  check("front", front, front > 0 && front <= 10, "(0, 10]");
  check("rear", rear, rear >= 0 && rear <= 10, "[0, 10]");
  check("width", width, width > 0 && width <= 10, "(0, 10]");
  check("lidar_forward", lidar_forward, std::abs(lidar_forward) <= 10, "[-10, 10]");
  check("watchdog", watchdog, watchdog > 0 && watchdog <= 10, "(0, 10]");
}

PlantDrive::PlantDrive(const PlantDriveParameters& parameters)
    : parameters_(checked(parameters)),
      yard_(yard_of(parameters)),
      vehicle_(parameters.vehicle, parameters.start),
      errors_(parameters.localisation, parameters.seed) {
  least_clearance_ = yard_.clearance(body());
  if (least_clearance_ <= 0) {
    throw std::invalid_argument("start: (" + std::to_string(parameters_.start.x) + ", " +
                                std::to_string(parameters_.start.y) + ") is in an obstacle");
  }
}

YardBox PlantDrive::body() const {
  const AckermannState& state = vehicle_.state();
  const double middle = (parameters_.front - parameters_.rear) / 2;
  return {.centre = {state.x + middle * std::cos(state.heading),
                     state.y + middle * std::sin(state.heading)},
          .heading = state.heading,
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

void PlantDrive::drive(int milliseconds) {
  for (int i = 0; i < milliseconds; ++i) {
    if (static_cast<double>(steps_ - commanded_at_) * kMillisecond > parameters_.watchdog) {
      vehicle_.command(0, steering_);
    }
    vehicle_.step();
    ++steps_;
    driven_ += std::abs(vehicle_.state().speed) * AckermannVehicle::kStep;
    const YardBox now = body();
    yard_.step(AckermannVehicle::kStep, now);
    const double clearance = yard_.clearance(now);
    least_clearance_ = std::min(least_clearance_, clearance);
    collisions_ += clearance <= 0 ? 1 : 0;
  }
}

AckermannState PlantDrive::measured(double dt) {
  AckermannState state = vehicle_.state();
  const auto error = errors_.next(dt);
  state.x += error.x;
  state.y += error.y;
  state.heading += error.heading;
  return state;
}

void PlantDrive::scan(std::vector<float>& ranges) const {
  const AckermannState& state = vehicle_.state();
  yard_.scan(parameters_.lidar,
             {state.x + parameters_.lidar_forward * std::cos(state.heading),
              state.y + parameters_.lidar_forward * std::sin(state.heading)},
             state.heading, parameters_.seed + static_cast<std::uint64_t>(steps_), ranges);
}

std::optional<double> PlantDrive::range_to_pipe() const {
  const auto& p = yard_.parameters();
  const AckermannState& state = vehicle_.state();
  const double pitch = p.aisle + p.row_width;
  const double aisle = std::floor(state.y / pitch);
  if (state.x < 0 || state.x > p.row_length || aisle < 0 || aisle >= p.rows - 1) {
    return std::nullopt;
  }
  // The rows begin and end half their width from their middles.
  const double to_left = (aisle + 1) * pitch - p.row_width / 2 - state.y;
  const double to_right = state.y - aisle * pitch - p.row_width / 2;
  return std::cos(state.heading) > 0 ? to_left : to_right;
}

}  // namespace pipescout
