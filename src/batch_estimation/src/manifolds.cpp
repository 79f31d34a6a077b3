// SPDX-License-Identifier: Apache-2.0
#include "manifolds.hpp"

#include <algorithm>
#include <exception>

namespace pipescout::estimation {
namespace {

using Vector = Eigen::Map<Eigen::Vector3d>;
using ConstVector = Eigen::Map<const Eigen::Vector3d>;
using Quaternion = Eigen::Map<Eigen::Quaterniond>;

constexpr int kQuaternion = kGlobalNumbers - 4;  // of the rack, in the globals
constexpr int kOwnNumbers = 11 + kImuScaleSize;

/// Normalised, so that the rounding of many steps does not add up.
geometry::SO3 rotation_at(const double* numbers) {
  return geometry::SO3::from_quaternion(Eigen::Map<const Eigen::Quaterniond>(numbers).normalized());
}

/// What Ceres may try but no state is: it then takes a shorter step.
template <class Move>
bool unless_absurd(Move&& move) {
  try {
    move();
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

void set_identity(int rows, int columns, double* jacobian) {
  std::fill(jacobian, jacobian + rows * columns, 0.0);
  for (int i = 0; i < std::min(rows, columns); ++i) {
    jacobian[i * columns + i] = 1;
  }
}

}  // namespace

void pack(const NavState& state, double* numbers) {
  Vector{numbers} = state.position;
  Vector{numbers + 3} = state.velocity;
  Vector{numbers + 6} = state.gyro_bias;
  Vector{numbers + 9} = state.accelerometer_bias;
  Quaternion{numbers + 12} = state.R_map_body.quaternion();
}

NavState unpack_state(const double* numbers) {
  return {.R_map_body = rotation_at(numbers + 12),
          .position = ConstVector(numbers),
          .velocity = ConstVector(numbers + 3),
          .gyro_bias = ConstVector(numbers + 6),
          .accelerometer_bias = ConstVector(numbers + 9)};
}

void pack(const GlobalStates& globals, double* numbers) {
  numbers[0] = globals.odometer_scale;
  numbers[1] = globals.mount_yaw;
  numbers[2] = globals.mount_pitch;
  Vector{numbers + 3} = globals.rack_position;
  Vector{numbers + 6} = globals.gps_lever_arm;
  numbers[9] = globals.gps_time_offset;
  numbers[10] = globals.visual_pose_time_offset;
  Eigen::Map<ImuScaleVector>(numbers + 11) = ImuScale{}.local(globals.imu_scale);
  Eigen::Map<OwnVector>(numbers + kOwnNumbers) = globals.own;
  Quaternion{numbers + kQuaternion} = globals.R_map_rack.quaternion();
}

GlobalStates unpack_globals(const double* numbers) {
  return {.odometer_scale = numbers[0],
          .mount_yaw = numbers[1],
          .mount_pitch = numbers[2],
          .rack_position = ConstVector(numbers + 3),
          .R_map_rack = rotation_at(numbers + kQuaternion),
          .gps_lever_arm = ConstVector(numbers + 6),
          .gps_time_offset = numbers[9],
          .visual_pose_time_offset = numbers[10],
          .imu_scale = ImuScale{}.retract(Eigen::Map<const ImuScaleVector>(numbers + 11)),
          .own = Eigen::Map<const OwnVector>(numbers + kOwnNumbers)};
}

bool StateManifold::Plus(const double* x, const double* delta, double* moved) const {
  return unless_absurd(
      [&] { pack(unpack_state(x).retract(Eigen::Map<const StateVector>(delta)), moved); });
}

bool StateManifold::PlusJacobian(const double* /*x*/, double* jacobian) const {
  set_identity(kStateNumbers, kStateSize, jacobian);
  return true;
}

bool StateManifold::Minus(const double* y, const double* x, double* difference) const {
  Eigen::Map<StateVector>(difference, kStateSize) = unpack_state(x).local(unpack_state(y));
  return true;
}

bool StateManifold::MinusJacobian(const double* /*x*/, double* jacobian) const {
  set_identity(kStateSize, kStateNumbers, jacobian);
  return true;
}

bool GlobalManifold::Plus(const double* x, const double* delta, double* moved) const {
  GlobalVector all = GlobalVector::Zero();
  for (std::size_t i = 0; i < estimated_.size(); ++i) {
    all[estimated_[i]] = delta[i];
  }
  return unless_absurd([&] { pack(unpack_globals(x).retract(all), moved); });
}

bool GlobalManifold::PlusJacobian(const double* /*x*/, double* jacobian) const {
  const std::size_t columns = estimated_.size();
  std::fill(jacobian, jacobian + kGlobalNumbers * columns, 0.0);
  for (std::size_t i = 0; i < columns; ++i) {
    jacobian[static_cast<std::size_t>(estimated_[i]) * columns + i] = 1;
  }
  return true;
}

bool GlobalManifold::Minus(const double* y, const double* x, double* difference) const {
  const GlobalVector all = unpack_globals(x).local(unpack_globals(y));
  for (std::size_t i = 0; i < estimated_.size(); ++i) {
    difference[i] = all[estimated_[i]];
  }
  return true;
}

bool GlobalManifold::MinusJacobian(const double* /*x*/, double* jacobian) const {
  std::fill(jacobian, jacobian + kGlobalNumbers * estimated_.size(), 0.0);
  for (std::size_t i = 0; i < estimated_.size(); ++i) {
    jacobian[i * kGlobalNumbers + static_cast<std::size_t>(estimated_[i])] = 1;
  }
  return true;
}

}  // namespace pipescout::estimation
