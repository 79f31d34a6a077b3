// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/ground_robot.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "pipescout/simulation/uav.hpp"
#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::SO3;

}  // namespace

void GroundRobotParameters::validate() const {
  using validation::check_above;
  using validation::check_within;
  check_within("wheel_base", wheel_base, 0.1, 10);
  check_within("track", track, 0.1, 10);
  check_within("wheels_ahead", wheels_ahead, -5, 5);
  check_within("ride_height", ride_height, 0, 5);
  check_within("heave_frequency", heave_frequency, 1, 100);
  check_within("tilt_frequency", tilt_frequency, 1, 100);
  check_within("damping", damping, 0.05, 2);
  check_within("lean", lean, 0, 0.1);
  check_above("largest_speed", largest_speed, 0, 20);
  check_above("largest_acceleration", largest_acceleration, 0, 10);
  check_above("largest_yaw_rate", largest_yaw_rate, 0, 5);
  check_within("drive_time", drive_time, 0.02, 5);
  check_within("steer_time", steer_time, 0.02, 5);
  check_within("side_slip", side_slip, 0, 1);
  check_within("side_slip_time", side_slip_time, 0.02, 5);
  check_within("wheel_scale_error", wheel_scale_error, 0, 0.2);
  check_within("wheel_noise", wheel_noise, 0, 1);
  check_within("traction_slip", traction_slip, 0, 0.1);
  check_within("slip_spacing", slip_spacing, 0, 1e6);
  check_within("slip_shortest", slip_shortest, 0.01, 1000);
  check_within("slip_longest", slip_longest, slip_shortest, 1000);
  check_within("slip_most", slip_most, 0, 1);
  check_within("wheel_resolution", wheel_resolution, 0, 1);
}

GroundRobot::GroundRobot(const GroundRobotParameters& parameters, Terrain terrain,
                         const Vector2d& place, double yaw, std::uint64_t seed)
    : parameters_(parameters),
      terrain_(std::move(terrain)),
      engine_(statistics::make_engine(seed, 6)) {
  parameters_.validate();
  if (!place.allFinite() || !std::isfinite(yaw)) {
    throw std::invalid_argument("ground_robot: its place and its yaw must be finite");
  }
  state_[kX] = place.x();
  state_[kY] = place.y();
  state_[kYaw] = yaw;
  ground_ = ground_under(state_);
  state_[kZ] = ground_.place[0] + parameters_.ride_height;
  state_[kPitch] = ground_.place[1];
  state_[kRoll] = ground_.place[2];
  for (Wheel& wheel : wheels_) {
    wheel.scale = 1 + parameters_.wheel_scale_error * statistics::normal(engine_);
    draw_burst(wheel);
  }
  measure(derivative(state_, ground_));
}

void GroundRobot::command(const GroundRobotCommand& command) noexcept {
  if (!std::isfinite(command.speed) || !std::isfinite(command.yaw_rate)) {
    ++bad_commands_;
    return;
  }
  command_.speed = std::clamp(command.speed, -parameters_.largest_speed, parameters_.largest_speed);
  command_.yaw_rate =
      std::clamp(command.yaw_rate, -parameters_.largest_yaw_rate, parameters_.largest_yaw_rate);
}

GroundRobot::Ground GroundRobot::ground_under(const State& state) const noexcept {
  const double base = parameters_.wheel_base;
  const double track = parameters_.track;
  const double c = std::cos(state[kYaw]);
  const double s = std::sin(state[kYaw]);
  const Vector2d forward(c, s);
  const Vector2d left(-s, c);
  const Vector2d velocity = state[kSpeed] * std::cos(state[kPitch]) * forward + state[kSide] * left;
  Eigen::Matrix<double, kWheels, 2> heights;  // and how fast they change
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kWheels); ++i) {
    const double ahead = parameters_.wheels_ahead + (i < 2 ? base / 2 : -base / 2);
    const double aside = i % 2 == 0 ? track / 2 : -track / 2;
    const Terrain::Place under = terrain_.at(state.head<2>() + ahead * forward + aside * left);
    const Vector2d passing = velocity + state[kYawRate] * (ahead * left - aside * forward);
    heights.row(i) << under.height, under.gradient.dot(passing);
  }
  const Eigen::RowVector2d climb =
      (heights.topRows<2>().colwise().sum() - heights.bottomRows<2>().colwise().sum()) / (2 * base);
  const Eigen::RowVector2d mean = heights.colwise().mean() - parameters_.wheels_ahead * climb;
  const Eigen::RowVector2d bank =
      (heights.row(0) + heights.row(2) - heights.row(1) - heights.row(3)) / (2 * track);
  // Roll comes after pitch: sin(roll) cos(pitch) is how far the left side rises.
  const double cp = 1 / std::sqrt(1 + climb[0] * climb[0]);
  const double tilt = bank[0] * cp;
  Ground result;
  result.place << mean[0], -std::atan(climb[0]), std::atan(tilt);
  const double pitch_rate = -climb[1] * cp * cp;
  const double tilt_rate = bank[1] * cp - bank[0] * cp * cp * cp * climb[0] * climb[1];
  result.rate << mean[1], pitch_rate, tilt_rate / (1 + tilt * tilt);
  return result;
}

GroundRobot::State GroundRobot::derivative(const State& state, const Ground& ground) const {
  const double cy = std::cos(state[kYaw]);
  const double sy = std::sin(state[kYaw]);
  const double level_speed = state[kSpeed] * std::cos(state[kPitch]);
  const double towards_left = level_speed * state[kYawRate];  // m/s^2
  const double wanted =
      std::clamp((command_.speed - state[kSpeed]) / parameters_.drive_time,
                 -parameters_.largest_acceleration, parameters_.largest_acceleration);
  Vector3d at_rest = ground.place;  // heave, pitch, roll
  at_rest[0] += parameters_.ride_height;
  at_rest[1] -= parameters_.lean * state[kAcceleration];
  at_rest[2] += parameters_.lean * towards_left;
  const Vector3d off = at_rest - Vector3d(state[kZ], state[kPitch], state[kRoll]);
  const Vector3d off_rate =
      ground.rate - Vector3d(state[kClimb], state[kPitchRate], state[kRollRate]);
  const Vector3d frequency(parameters_.heave_frequency, parameters_.tilt_frequency,
                           parameters_.tilt_frequency);
  const Vector3d spring = frequency.cwiseAbs2().cwiseProduct(off) +
                          2 * parameters_.damping * frequency.cwiseProduct(off_rate);

  State result;
  result[kX] = level_speed * cy - state[kSide] * sy;
  result[kY] = level_speed * sy + state[kSide] * cy;
  result[kZ] = state[kClimb];
  result[kYaw] = state[kYawRate];
  result[kPitch] = state[kPitchRate];
  result[kRoll] = state[kRollRate];
  result[kSpeed] = state[kAcceleration];
  result[kSide] =
      (-parameters_.side_slip * (towards_left + kGravity * std::sin(state[kRoll])) - state[kSide]) /
      parameters_.side_slip_time;
  result[kClimb] = spring[0];
  result[kPitchRate] = spring[1];
  result[kRollRate] = spring[2];
  result[kYawRate] = (command_.yaw_rate - state[kYawRate]) / parameters_.steer_time;
  result[kAcceleration] = (wanted - state[kAcceleration]) / parameters_.drive_time;
  result[kDistance] = state[kSpeed];
  return result;
}

void GroundRobot::measure(const State& derivative) {
  const double yaw = state_[kYaw];
  const double pitch = state_[kPitch];
  const double roll = state_[kRoll];
  const double cp = std::cos(pitch);
  const double sp = std::sin(pitch);
  const double level_acceleration =
      derivative[kSpeed] * cp - state_[kSpeed] * sp * state_[kPitchRate];
  const double level_speed = state_[kSpeed] * cp;
  const double r = state_[kYawRate];
  const SO3 R_map_yaw = SO3::about_z(yaw);

  motion_.time = static_cast<double>(steps_) * kStep;
  motion_.T_map_body = geometry::SE3(SO3::from_roll_pitch_yaw({roll, pitch, yaw}),
                                     {state_[kX], state_[kY], state_[kZ]});
  motion_.velocity = R_map_yaw * Vector3d(level_speed, state_[kSide], state_[kClimb]);
  motion_.acceleration =
      R_map_yaw * Vector3d(level_acceleration - r * state_[kSide],
                           derivative[kSide] + r * level_speed, derivative[kClimb]);
  // Body rates of Rz(yaw) Ry(pitch) Rx(roll) and their derivatives.
  const double cr = std::cos(roll);
  const double sr = std::sin(roll);
  const double q = state_[kPitchRate];
  const double p = state_[kRollRate];
  const double yaw_acceleration = derivative[kYawRate];
  motion_.angular_rate << p - r * sp, q * cr + r * cp * sr, -q * sr + r * cp * cr;
  motion_.angular_acceleration << derivative[kRollRate] - yaw_acceleration * sp - r * cp * q,
      derivative[kPitchRate] * cr - q * sr * p + yaw_acceleration * cp * sr - r * sp * q * sr +
          r * cp * cr * p,
      -derivative[kPitchRate] * sr - q * cr * p + yaw_acceleration * cp * cr - r * sp * q * cr -
          r * cp * sr * p;
}

void GroundRobot::step() {
  const State begin = state_;
  const State k1 = derivative(begin, ground_);
  // Of the place at the end only the square of the step is missing: some um.
  const Ground next = ground_under(begin + kStep * k1);
  Ground half;  // cubic between both
  half.place = (ground_.place + next.place) / 2 + kStep / 8 * (ground_.rate - next.rate);
  half.rate = 1.5 / kStep * (next.place - ground_.place) - (ground_.rate + next.rate) / 4;
  const State k2 = derivative(begin + kStep / 2 * k1, half);
  const State k3 = derivative(begin + kStep / 2 * k2, half);
  const State k4 = derivative(begin + kStep * k3, next);
  state_ += kStep / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  ground_ = next;
  ++steps_;
  measure(derivative(state_, ground_));
  turn_wheels(state_[kDistance] - begin[kDistance], state_[kYaw] - begin[kYaw]);
}

void GroundRobot::draw_burst(Wheel& wheel) {
  if (parameters_.slip_spacing <= 0) {
    wheel.burst_begin = std::numeric_limits<double>::infinity();
    return;
  }
  wheel.burst_begin = wheel.path + parameters_.slip_spacing * statistics::exponential(engine_);
  wheel.burst_end = wheel.burst_begin + statistics::uniform(engine_, parameters_.slip_shortest,
                                                            parameters_.slip_longest);
  wheel.burst = parameters_.slip_most * statistics::uniform(engine_);
}

void GroundRobot::turn_wheels(double moved, double turned) {
  const double traction = state_[kAcceleration] - kGravity * std::sin(state_[kPitch]);
  for (std::size_t i = 0; i < kWheels; ++i) {
    Wheel& wheel = wheels_[i];
    const double aside = (i % 2 == 0 ? 0.5 : -0.5) * parameters_.track;
    const double rolled = moved - aside * turned;
    wheel.path += std::abs(rolled);
    if (wheel.path >= wheel.burst_end && wheel.path >= wheel.burst_begin) {
      draw_burst(wheel);
    }
    const double burst = wheel.path >= wheel.burst_begin ? wheel.burst : 0;
    // Under traction a wheel turns on, when braking it turns less, whichever way it goes.
    wheel.turned +=
        rolled * wheel.scale * (1 + burst) +
        parameters_.traction_slip * traction * std::abs(rolled) +
        parameters_.wheel_noise * std::sqrt(std::abs(rolled)) * statistics::normal(engine_);
  }
}

std::array<double, kWheels> GroundRobot::odometers() const noexcept {
  std::array<double, kWheels> shown{};
  for (std::size_t i = 0; i < kWheels; ++i) {
    const double resolution = parameters_.wheel_resolution;
    shown[i] = resolution > 0 ? resolution * std::floor(wheels_[i].turned / resolution)
                              : wheels_[i].turned;
  }
  return shown;
}

}  // namespace pipescout::simulation
