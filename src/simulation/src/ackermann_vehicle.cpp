// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/ackermann_vehicle.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

constexpr double kGravity = 9.81;

std::size_t steps_of(double seconds) {
  return static_cast<std::size_t>(std::lround(seconds / AckermannVehicle::kStep));
}

}  // namespace

void AckermannVehicleParameters::validate() const {
  validation::check_within("wheel_base", wheel_base, 0.1, 10);
  validation::check_above("largest_steering", largest_steering, 0, 1.4);
  validation::check_above("steering_rate", steering_rate, 0, 10);
  validation::check_within("steering_delay", steering_delay, 0, 1);
  validation::check_within("drive_delay", drive_delay, 0, 1);
  validation::check_above("largest_acceleration", largest_acceleration, 0, 10);
  validation::check_above("largest_deceleration", largest_deceleration, 0, 10);
  validation::check_within("understeer", understeer, 0, 0.1);
  validation::check_within("wheel_slip", wheel_slip, 0, 0.2);
  validation::check_within("slope", slope, 0, 0.3);
  validation::check_within("side_slip", side_slip, 0, 1);
}

AckermannVehicle::AckermannVehicle(const AckermannVehicleParameters& parameters,
                                   const AckermannState& start)
    : parameters_(parameters), state_(start) {
  parameters_.validate();
  command_.steering = start.steering;
  history_.assign(
      std::max(steps_of(parameters_.steering_delay), steps_of(parameters_.drive_delay)) + 1,
      command_);
}

void AckermannVehicle::command(double speed, double steering) {
  command_ = std::isfinite(speed) && std::isfinite(steering) ? Command{speed, steering}
                                                             : Command{0, state_.steering};
}

void AckermannVehicle::step() {
  const auto& p = parameters_;
  const std::size_t size = history_.size();
  const std::size_t now = static_cast<std::size_t>(steps_++) % size;
  history_[now] = command_;
  const double steering = history_[(now + size - steps_of(p.steering_delay)) % size].steering;
  const double speed = history_[(now + size - steps_of(p.drive_delay)) % size].speed;

  const double turn = p.steering_rate * kStep;
  state_.steering += std::clamp(
      std::clamp(steering, -p.largest_steering, p.largest_steering) - state_.steering, -turn, turn);
  const bool brakes = std::abs(speed) < std::abs(state_.speed) || speed * state_.speed < 0;
  const double change = (brakes ? p.largest_deceleration : p.largest_acceleration) * kStep;
  // The drive holds a commanded speed against the slope up to its strength.
  const double along = kGravity * std::sin(p.slope) * std::cos(state_.heading - p.uphill) * kStep;
  const double wanted = std::clamp(speed - state_.speed, -change, change);
  const bool at_its_limit = std::abs(wanted) >= change;
  state_.speed += at_its_limit ? wanted - along : wanted;

  const double over_ground = state_.speed * (1 - p.wheel_slip);
  const double lateral = over_ground * over_ground * std::tan(state_.steering) / p.wheel_base;
  const double effective = state_.steering - p.understeer * lateral;
  state_.yaw_rate = over_ground * std::tan(effective) / p.wheel_base;
  const bool moves = std::abs(over_ground) > 0.01;
  const double sideways =
      moves ? p.side_slip * kGravity * std::sin(p.slope) * std::sin(state_.heading - p.uphill) : 0;
  const double middle = state_.heading + 0.5 * state_.yaw_rate * kStep;
  state_.x += (over_ground * std::cos(middle) - sideways * std::sin(middle)) * kStep;
  state_.y += (over_ground * std::sin(middle) + sideways * std::cos(middle)) * kStep;
  state_.heading = std::remainder(state_.heading + state_.yaw_rate * kStep, 6.283185307179586);
}

}  // namespace pipescout::simulation
