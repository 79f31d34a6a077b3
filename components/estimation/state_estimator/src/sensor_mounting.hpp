// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/geometry/se3.hpp"

namespace pipescout {

/// Where the sensors are on the robot, and what that makes of poses. `base`: the base frame of the
/// robot; `body`: that of the estimator, with the axes of `base` and its origin at the IMU.
struct SensorMounting {
  Eigen::Vector3d imu = Eigen::Vector3d::Zero();  ///< m, in the base frame
  geometry::SE3 T_base_camera{};

  [[nodiscard]] Eigen::Vector3d in_body(const Eigen::Vector3d& in_base) const {
    return in_base - imu;
  }
  [[nodiscard]] geometry::SE3 T_body_base() const { return {geometry::SO3(), -imu}; }

  /// `covariance` of the camera's position along the rack's axes and of its rotation about them, as
  /// geometry_msgs/PoseWithCovariance has it.
  [[nodiscard]] estimation::VisualPoseMeasurement visual_pose(
      double time, const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance) const;

  /// The inverse: the pose that an image of the time of the estimate shows, that of the camera in
  /// the rack frame, and its covariance, in the same form. `covariance` is that of [position;
  /// rotation] of the body as NavState has them, `of_globals` that of GlobalStates, which hold the
  /// rack, the delay of images and, by `mounting` as VisualPoseMeasurement has it, where the camera
  /// is instead of at `T_base_camera`. Body, rack, delay and mounting are taken to be independent.
  struct CameraPose {
    geometry::SE3 T_rack_camera{};
    geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  };
  using GlobalMatrix = Eigen::Matrix<double, estimation::kGlobalSize, estimation::kGlobalSize>;
  [[nodiscard]] CameraPose camera_pose(const estimation::Estimate& estimate,
                                       const geometry::Matrix6d& covariance,
                                       const estimation::GlobalStates& globals,
                                       const GlobalMatrix& of_globals, int mounting = -1) const;

  /// An estimate as nav_msgs/Odometry has it: pose of the base in the map with rotations about the
  /// map's axes, velocities in the base frame, [linear; angular].
  struct BaseMotion {
    geometry::SE3 T_map_base{};
    geometry::Matrix6d pose_covariance = geometry::Matrix6d::Zero();
    geometry::Vector6d twist = geometry::Vector6d::Zero();
    geometry::Matrix6d twist_covariance = geometry::Matrix6d::Zero();
  };
  /// `rate_variance`: (rad/s)^2, of one reading of the gyro, per axis, beside its bias.
  [[nodiscard]] BaseMotion base_motion(const estimation::Estimate& estimate,
                                       const estimation::StateMatrix& covariance,
                                       double rate_variance) const;
};

}  // namespace pipescout
