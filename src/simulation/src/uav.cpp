// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/uav.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout::simulation {
namespace {

using geometry::SE3;
using geometry::SO3;

// m/s^2: rotors keep pushing, so that there is always a direction of thrust to hold.
constexpr double kLeastLift = 2.0;

Eigen::Vector3d saturated(const Eigen::Vector3d& v, double largest) {
  const double norm = v.norm();
  return norm > largest ? Eigen::Vector3d(v * (largest / norm)) : v;
}

double yaw_of(const SO3& R_rack_body) {
  const Eigen::Vector3d forward = R_rack_body * Eigen::Vector3d::UnitX();
  return std::atan2(forward.y(), forward.x());
}

/// Attitude with the body's z axis along `up`, not level, and its x axis straight above or below
/// the direction of the yaw.
SO3 attitude(const Eigen::Vector3d& up, double yaw) {
  const Eigen::Vector3d heading(std::cos(yaw), std::sin(yaw), 0);
  Eigen::Matrix3d R_rack_body;
  R_rack_body.col(2) = up.normalized();
  R_rack_body.col(0) = (up.z() * heading - heading.dot(up) * Eigen::Vector3d::UnitZ()).normalized();
  R_rack_body.col(1) = R_rack_body.col(2).cross(R_rack_body.col(0));
  return SO3::from_matrix(R_rack_body);
}

}  // namespace

void UavParameters::validate() const {
  using validation::check_above;
  using validation::check_within;
  check_within("linear_drag", linear_drag, 0, 10);
  check_within("quadratic_drag", quadratic_drag, 0, 10);
  check_within("rotational_drag", rotational_drag, 0, 50);
  check_above("largest_tilt", largest_tilt, 0, 1.2);
  check_above("largest_thrust", largest_thrust, kGravity, 100);
  check_above("velocity_gain", velocity_gain, 0, 20);
  check_within("gust_bandwidth", gust_bandwidth, 0, 50);
  check_above("attitude_frequency", attitude_frequency, 0, 50);
  check_above("attitude_damping", attitude_damping, 0, 3);
  check_above("largest_speed", largest_speed, 0, 30);
  check_above("largest_yaw_rate", largest_yaw_rate, 0, 6);
  check_above("command_time_out", command_time_out, 0, 1000);
  check_within("velocity_error", velocity_error, 0, 1);
  check_within("velocity_error_time", velocity_error_time, 0.1, 1000);
}

Uav::Uav(const UavParameters& parameters, const Eigen::Vector3d& position, double yaw,
         const Eigen::Vector3d& mean_wind, std::uint64_t seed)
    : parameters_(parameters), engine_(statistics::make_engine(seed, 2)), wanted_yaw_(yaw) {
  parameters_.validate();
  if (!position.allFinite() || !std::isfinite(yaw) || !mean_wind.allFinite()) {
    throw std::invalid_argument("uav: its position, its yaw and the mean wind must be finite");
  }
  expected_drag_ = air_acceleration(Eigen::Vector3d::Zero(), mean_wind);
  const Eigen::Vector3d push = kGravity * Eigen::Vector3d::UnitZ() - expected_drag_;
  thrust_ = push.norm();
  if (push.z() < kLeastLift || thrust_ > parameters_.largest_thrust ||
      push.head<2>().norm() > push.z() * std::tan(parameters_.largest_tilt)) {
    throw std::invalid_argument("uav: it cannot hover in a mean wind of " +
                                validation::number_text(mean_wind.norm()) + " m/s");
  }
  const SO3 R_rack_body = attitude(push, yaw);
  state_.T_rack_body = SE3(R_rack_body, position);
  state_.specific_force = R_rack_body.inverse() * (kGravity * Eigen::Vector3d::UnitZ());
  for (double& entry : velocity_error_) {
    entry = parameters_.velocity_error * statistics::normal(engine_);
  }
}

void Uav::command(const UavCommand& command) noexcept {
  if (!command.velocity.allFinite() || !std::isfinite(command.yaw_rate)) {
    ++bad_commands_;
    return;
  }
  command_.velocity = saturated(command.velocity, parameters_.largest_speed);
  command_.yaw_rate =
      std::clamp(command.yaw_rate, -parameters_.largest_yaw_rate, parameters_.largest_yaw_rate);
  commanded_at_ = state_.time;
}

Eigen::Vector3d Uav::air_acceleration(const Eigen::Vector3d& velocity,
                                      const Eigen::Vector3d& wind) const noexcept {
  const Eigen::Vector3d through_air = velocity - wind;
  return -(parameters_.linear_drag + parameters_.quadratic_drag * through_air.norm()) * through_air;
}

void Uav::drift_velocity_error() {
  const double decay = std::exp(-kStep / parameters_.velocity_error_time);
  const double growth = parameters_.velocity_error * std::sqrt(1 - decay * decay);
  for (double& entry : velocity_error_) {
    entry = decay * entry + growth * statistics::normal(engine_);
  }
}

Uav::Actuation Uav::autopilot() {
  const bool heard = state_.time - commanded_at_ <= parameters_.command_time_out;
  const UavCommand wanted = heard ? command_ : UavCommand{};
  const SO3& R_rack_body = state_.T_rack_body.rotation();
  const Eigen::Vector3d error =
      SO3::about_z(yaw_of(R_rack_body)) * wanted.velocity - (state_.velocity + velocity_error_);
  // What the accelerometer shows beyond the thrust is the force of the air.
  const Eigen::Vector3d drag =
      R_rack_body * (state_.specific_force - Eigen::Vector3d(0, 0, thrust_));
  expected_drag_ -= std::expm1(-parameters_.gust_bandwidth * kStep) * (drag - expected_drag_);
  Eigen::Vector3d push =
      parameters_.velocity_gain * error - expected_drag_ + kGravity * Eigen::Vector3d::UnitZ();
  const double lift = std::clamp(push.z(), kLeastLift, parameters_.largest_thrust);
  const double farthest = lift * std::tan(parameters_.largest_tilt);
  const double across = push.head<2>().norm();
  push.z() = lift;
  if (across > farthest) {
    push.head<2>() *= farthest / across;
  }

  wanted_yaw_ = std::remainder(wanted_yaw_ + wanted.yaw_rate * kStep, 2 * std::numbers::pi);
  thrust_ =
      std::clamp(push.dot(R_rack_body * Eigen::Vector3d::UnitZ()), 0.0, parameters_.largest_thrust);
  return {.thrust = thrust_,
          .R_rack_wanted = attitude(push, wanted_yaw_),
          .wanted_rate = {0, 0, wanted.yaw_rate}};
}

Uav::Motion Uav::derivative(const Motion& motion, const Actuation& actuation,
                            const WindSample& wind) const {
  const Eigen::Vector3d turn = motion.segment<3>(6);
  const Eigen::Vector3d rate = motion.tail<3>();
  const SO3 R_rack_body = state_.T_rack_body.rotation() * SO3::exp(turn);
  const SO3 R_body_rack = R_rack_body.inverse();
  const double frequency = parameters_.attitude_frequency;

  Motion result;
  result.head<3>() = motion.segment<3>(3);
  result.segment<3>(3) = R_rack_body * Eigen::Vector3d(0, 0, actuation.thrust) +
                         air_acceleration(motion.segment<3>(3), wind.velocity) -
                         kGravity * Eigen::Vector3d::UnitZ();
  result.segment<3>(6) = SO3::right_jacobian_inverse(turn) * rate;
  result.tail<3>() =
      frequency * frequency * (R_body_rack * actuation.R_rack_wanted).log() +
      2 * parameters_.attitude_damping * frequency * (R_body_rack * actuation.wanted_rate - rate) +
      parameters_.rotational_drag * (R_body_rack * wind.rotation_rate - rate);
  return result;
}

void Uav::step(const WindSample& wind) {
  const Actuation actuation = autopilot();
  Motion begin;
  begin << state_.T_rack_body.translation(), state_.velocity, Eigen::Vector3d::Zero(),
      state_.angular_rate;
  const Motion k1 = derivative(begin, actuation, wind);
  const Motion k2 = derivative(begin + kStep / 2 * k1, actuation, wind);
  const Motion k3 = derivative(begin + kStep / 2 * k2, actuation, wind);
  const Motion k4 = derivative(begin + kStep * k3, actuation, wind);
  const Motion end = begin + kStep / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  const Motion change = derivative(end, actuation, wind);

  ++steps_;
  state_.time = static_cast<double>(steps_) * kStep;
  state_.T_rack_body =
      SE3(state_.T_rack_body.rotation() * SO3::exp(end.segment<3>(6)), end.head<3>());
  state_.velocity = end.segment<3>(3);
  state_.angular_rate = end.tail<3>();
  state_.acceleration = change.segment<3>(3);
  state_.specific_force = state_.T_rack_body.rotation().inverse() *
                          (state_.acceleration + kGravity * Eigen::Vector3d::UnitZ());
  drift_velocity_error();
}

}  // namespace pipescout::simulation
