// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/geometry/so3.hpp"

/// The estimated states: the motion of one body, and slowly varying parameters of its sensors and
/// its surroundings. Frames: `map` (z up, gravity along -z), `body` (the IMU's), `rack`. SI units,
/// rad.
namespace pipescout::estimation {

inline constexpr int kStateSize = 15;
/// Indices of the parts of a state in its tangent space.
inline constexpr int kPosition = 0;
inline constexpr int kRotation = 3;
inline constexpr int kVelocity = 6;
inline constexpr int kGyroBias = 9;
inline constexpr int kAccelerometerBias = 12;

/// Global states of the user, see GlobalStates::own.
inline constexpr int kOwnSize = 8;
inline constexpr int kGlobalSize = 32 + kOwnSize;
/// Indices of the parts of the global states in their tangent space.
inline constexpr int kOdometerScale = 0;
inline constexpr int kMountYaw = 1;
inline constexpr int kMountPitch = 2;
inline constexpr int kRackPosition = 3;
inline constexpr int kRackRotation = 6;
inline constexpr int kGpsLeverArm = 9;
inline constexpr int kGpsTimeOffset = 12;
inline constexpr int kVisualPoseTimeOffset = 13;
inline constexpr int kImuScale = 14;
inline constexpr int kImuScaleSize = 18;
inline constexpr int kOwnStates = 32;

using StateVector = Eigen::Matrix<double, kStateSize, 1>;
using StateMatrix = Eigen::Matrix<double, kStateSize, kStateSize>;
using ImuScaleVector = Eigen::Matrix<double, kImuScaleSize, 1>;
using OwnVector = Eigen::Matrix<double, kOwnSize, 1>;
using GlobalVector = Eigen::Matrix<double, kGlobalSize, 1>;

/// The body at one time. Tangent space: [position; rotation; velocity; gyro bias; accelerometer
/// bias]. Position and velocity are perturbed in the map frame, p' = p + d; the rotation in the
/// body frame, R' = R exp(d).
struct NavState {
  geometry::SO3 R_map_body{};
  Eigen::Vector3d position = Eigen::Vector3d::Zero();            ///< m, of the body in the map
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();            ///< m/s, in the map
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();           ///< rad/s, measured minus true
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< m/s^2, measured minus true

  /// This state moved by `d`. Throws std::invalid_argument when the rotation in `d` is not finite.
  [[nodiscard]] NavState retract(const StateVector& d) const;
  /// The `d` with retract(d) = other.
  [[nodiscard]] StateVector local(const NavState& other) const noexcept;
  [[nodiscard]] bool is_finite() const noexcept;
  [[nodiscard]] geometry::SE3 T_map_body() const { return {R_map_body, position}; }
};

/// Matrices that multiply the bias-free readings of an IMU, in the body: scale factors of the axes
/// on the diagonal, misalignment and non-orthogonality off the diagonal. Tangent space: [gyro;
/// accelerometer], each row by row.
struct ImuScale {
  Eigen::Matrix3d gyro = Eigen::Matrix3d::Identity();           ///< true rate / measured
  Eigen::Matrix3d accelerometer = Eigen::Matrix3d::Identity();  ///< true force / measured

  /// As those of NavState.
  [[nodiscard]] ImuScale retract(const ImuScaleVector& d) const;
  [[nodiscard]] ImuScaleVector local(const ImuScale& other) const noexcept;
  [[nodiscard]] bool is_finite() const noexcept;
};

/// Slow states that all keyframes share. Tangent space: [odometer scale; mount yaw; mount pitch;
/// rack position (map frame); rack rotation (R' = R exp(d)); lever arm of the GPS antenna; time
/// offset of the GPS; that of visual poses; scale of the IMU; own states].
struct GlobalStates {
  double odometer_scale = 1;  ///< true distance / that of the fused odometer
  /// rad, direction of travel in the body, Rz(yaw) Ry(pitch) x
  double mount_yaw = 0;
  double mount_pitch = 0;
  Eigen::Vector3d rack_position = Eigen::Vector3d::Zero();  ///< m, of the rack frame in the map
  geometry::SO3 R_map_rack{};
  Eigen::Vector3d gps_lever_arm = Eigen::Vector3d::Zero();  ///< m, of the antenna in the body
  double gps_time_offset = 0;          ///< s, delay of a position relative to its stamp
  double visual_pose_time_offset = 0;  ///< s, the same of a visual pose
  ImuScale imu_scale{};
  /// Scalars that only factors of the user give a meaning, such as the bias of a sensor of his.
  OwnVector own = OwnVector::Zero();

  /// As those of NavState.
  [[nodiscard]] GlobalStates retract(const GlobalVector& d) const;
  [[nodiscard]] GlobalVector local(const GlobalStates& other) const noexcept;
  [[nodiscard]] bool is_finite() const noexcept;
};

/// Derivatives of the residual of a factor of N rows. A factor of one time uses `from` only.
template <int N>
struct Jacobians {
  Eigen::Matrix<double, N, kStateSize> from = Eigen::Matrix<double, N, kStateSize>::Zero();
  Eigen::Matrix<double, N, kStateSize> to = Eigen::Matrix<double, N, kStateSize>::Zero();
  Eigen::Matrix<double, N, kGlobalSize> globals = Eigen::Matrix<double, N, kGlobalSize>::Zero();
};

}  // namespace pipescout::estimation
