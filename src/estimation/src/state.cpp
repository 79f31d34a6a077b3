// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/state.hpp"

#include <cmath>

namespace pipescout::estimation {

using geometry::SO3;
using ByRows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

NavState NavState::retract(const StateVector& d) const {
  return {.R_map_body = R_map_body * SO3::exp(d.segment<3>(kRotation)),
          .position = position + d.segment<3>(kPosition),
          .velocity = velocity + d.segment<3>(kVelocity),
          .gyro_bias = gyro_bias + d.segment<3>(kGyroBias),
          .accelerometer_bias = accelerometer_bias + d.segment<3>(kAccelerometerBias)};
}

StateVector NavState::local(const NavState& other) const noexcept {
  StateVector d;
  d.segment<3>(kPosition) = other.position - position;
  d.segment<3>(kRotation) = (R_map_body.inverse() * other.R_map_body).log();
  d.segment<3>(kVelocity) = other.velocity - velocity;
  d.segment<3>(kGyroBias) = other.gyro_bias - gyro_bias;
  d.segment<3>(kAccelerometerBias) = other.accelerometer_bias - accelerometer_bias;
  return d;
}

bool NavState::is_finite() const noexcept {
  return R_map_body.quaternion().coeffs().allFinite() && position.allFinite() &&
         velocity.allFinite() && gyro_bias.allFinite() && accelerometer_bias.allFinite();
}

ImuScale ImuScale::retract(const ImuScaleVector& d) const {
  return {.gyro = gyro + ByRows::Map(d.data()),
          .accelerometer = accelerometer + ByRows::Map(d.data() + 9)};
}

ImuScaleVector ImuScale::local(const ImuScale& other) const noexcept {
  ImuScaleVector d;
  ByRows::Map(d.data()) = other.gyro - gyro;
  ByRows::Map(d.data() + 9) = other.accelerometer - accelerometer;
  return d;
}

bool ImuScale::is_finite() const noexcept {
  return gyro.allFinite() && accelerometer.allFinite();
}

GlobalStates GlobalStates::retract(const GlobalVector& d) const {
  return {.odometer_scale = odometer_scale + d[kOdometerScale],
          .mount_yaw = mount_yaw + d[kMountYaw],
          .mount_pitch = mount_pitch + d[kMountPitch],
          .rack_position = rack_position + d.segment<3>(kRackPosition),
          .R_map_rack = R_map_rack * SO3::exp(d.segment<3>(kRackRotation)),
          .gps_lever_arm = gps_lever_arm + d.segment<3>(kGpsLeverArm),
          .gps_time_offset = gps_time_offset + d[kGpsTimeOffset],
          .visual_pose_time_offset = visual_pose_time_offset + d[kVisualPoseTimeOffset],
          .imu_scale = imu_scale.retract(d.segment<kImuScaleSize>(kImuScale)),
          .own = own + d.segment<kOwnSize>(kOwnStates)};
}

GlobalVector GlobalStates::local(const GlobalStates& other) const noexcept {
  GlobalVector d;
  d[kOdometerScale] = other.odometer_scale - odometer_scale;
  d[kMountYaw] = other.mount_yaw - mount_yaw;
  d[kMountPitch] = other.mount_pitch - mount_pitch;
  d.segment<3>(kRackPosition) = other.rack_position - rack_position;
  d.segment<3>(kRackRotation) = (R_map_rack.inverse() * other.R_map_rack).log();
  d.segment<3>(kGpsLeverArm) = other.gps_lever_arm - gps_lever_arm;
  d[kGpsTimeOffset] = other.gps_time_offset - gps_time_offset;
  d[kVisualPoseTimeOffset] = other.visual_pose_time_offset - visual_pose_time_offset;
  d.segment<kImuScaleSize>(kImuScale) = imu_scale.local(other.imu_scale);
  d.segment<kOwnSize>(kOwnStates) = other.own - own;
  return d;
}

bool GlobalStates::is_finite() const noexcept {
  return std::isfinite(odometer_scale) && std::isfinite(mount_yaw) && std::isfinite(mount_pitch) &&
         rack_position.allFinite() && R_map_rack.quaternion().coeffs().allFinite() &&
         gps_lever_arm.allFinite() && std::isfinite(gps_time_offset) &&
         std::isfinite(visual_pose_time_offset) && imu_scale.is_finite() && own.allFinite();
}

}  // namespace pipescout::estimation
