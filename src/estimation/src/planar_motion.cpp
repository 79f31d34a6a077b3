// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/planar_motion.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {

namespace {

constexpr double kRounding = 1e-6;  // of a number of steps
constexpr double kWheelTurnNoise =
    3e-3;                                // rad/s/sqrt(Hz): how far wheels are from what an IMU says
constexpr double kWheelTurnBias = 3e-3;  // rad/s, of wheels that differ
constexpr double kWheelForceNoise = 0.1;  // m/s^2/sqrt(Hz)

}  // namespace

void PlanarMotionParameters::validate() const {
  validation::check_between("PlanarMotionParameters.gravity", gravity, 0, 100);
  validation::check_within("PlanarMotionParameters.step", step, 1e-3, 1);
  validation::check_within("PlanarMotionParameters.longest_gap", longest_gap, step, 60);
}

PlanarMotion::PlanarMotion(PlanarMotionParameters parameters) : parameters_(parameters) {
  parameters_.validate();
}

const std::vector<ImuReading>& PlanarMotion::add(double time, double speed, double yaw_rate) {
  if (!std::isfinite(time) || !std::isfinite(speed) || !std::isfinite(yaw_rate)) {
    validation::refuse("motion at ", time, " s: speed ", speed, " m/s, yaw rate ", yaw_rate,
                       " rad/s; expected finite numbers");
  }
  readings_.clear();
  if (last_ && time <= last_->time) {
    return readings_;
  }
  const Motion to{time, speed, yaw_rate};
  if (last_ && time - last_->time <= parameters_.longest_gap) {
    const double length = time - last_->time;
    const int steps =
        std::max(1, static_cast<int>(std::ceil(length / parameters_.step - kRounding)));
    const double acceleration = (speed - last_->speed) / length;
    for (int k = 0; k < steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      const double rate = last_->yaw_rate + share * (yaw_rate - last_->yaw_rate);
      const double forwards = last_->speed + share * (speed - last_->speed);
      readings_.push_back({.time = last_->time + share * length,
                           .specific_force = {acceleration, forwards * rate, parameters_.gravity},
                           .angular_rate = {0, 0, rate}});
    }
  }
  last_ = to;
  return readings_;
}

void set_planar(StateEstimatorParameters& parameters) {
  parameters.specific_force_scale = 1;
  parameters.R_body_imu = {};
  parameters.smoother.imu_noise.gyro = kWheelTurnNoise;
  parameters.smoother.imu_noise.accelerometer = kWheelForceNoise;
  parameters.start.largest_gyro_bias = kWheelTurnBias;
  parameters.smoother.global_deviations.mount_yaw = 0;
  parameters.smoother.global_deviations.mount_pitch = 0;
}

}  // namespace pipescout::estimation
