// SPDX-License-Identifier: Apache-2.0
#include "sensor_mounting.hpp"

#include "pipescout/geometry/so3.hpp"

namespace pipescout {

namespace {

using estimation::GlobalStates;
using estimation::NavState;
using geometry::Matrix6d;
using geometry::SE3;
using geometry::SO3;

}  // namespace

estimation::VisualPoseMeasurement SensorMounting::visual_pose(double time, const SE3& T_rack_camera,
                                                              const Matrix6d& covariance) const {
  estimation::VisualPoseMeasurement result;
  result.time = time;
  result.T_rack_body = T_rack_camera * T_base_camera.inverse() * SE3(SO3(), imu);
  result.camera = in_body(T_base_camera.translation());
  const Eigen::Vector3d arm = result.T_rack_body.translation() - T_rack_camera.translation();
  Matrix6d by_camera = Matrix6d::Identity();
  by_camera.topRightCorner<3, 3>() = -geometry::skew(arm);
  by_camera.bottomRightCorner<3, 3>() = result.T_rack_body.rotation().matrix().transpose();
  result.covariance = by_camera * covariance * by_camera.transpose();
  result.covariance = (0.5 * (result.covariance + result.covariance.transpose())).eval();
  return result;
}

SensorMounting::CameraPose SensorMounting::camera_pose(const NavState& state,
                                                       const Matrix6d& covariance,
                                                       const GlobalStates& globals,
                                                       const Matrix6d& rack_covariance) const {
  const SE3 T_map_rack(globals.R_map_rack, globals.rack_position);
  const SE3 T_map_camera = state.T_map_body() * T_body_base() * T_base_camera;
  CameraPose result;
  result.T_rack_camera = T_map_rack.inverse() * T_map_camera;
  const Eigen::Matrix3d R_rack_map = globals.R_map_rack.matrix().transpose();
  const Eigen::Matrix3d R_rack_body = R_rack_map * state.R_map_body.matrix();
  const Eigen::Vector3d arm = R_rack_map * (T_map_camera.translation() - state.position);
  // p_camera = R_r^T (p + R l - p_r), rotations to the right of R and R_r.
  Matrix6d by_body = Matrix6d::Zero();
  by_body.topLeftCorner<3, 3>() = R_rack_map;
  by_body.topRightCorner<3, 3>() = -geometry::skew(arm) * R_rack_body;
  by_body.bottomRightCorner<3, 3>() = R_rack_body;
  Matrix6d by_rack = Matrix6d::Zero();
  by_rack.topLeftCorner<3, 3>() = -R_rack_map;
  by_rack.topRightCorner<3, 3>() = geometry::skew(result.T_rack_camera.translation());
  by_rack.bottomRightCorner<3, 3>() = -Eigen::Matrix3d::Identity();
  result.covariance =
      by_body * covariance * by_body.transpose() + by_rack * rack_covariance * by_rack.transpose();
  return result;
}

SensorMounting::BaseMotion SensorMounting::base_motion(const estimation::Estimate& estimate,
                                                       const estimation::StateMatrix& covariance,
                                                       double rate_variance) const {
  using Jacobian = Eigen::Matrix<double, 6, estimation::kStateSize>;
  const NavState& state = estimate.state;
  const Eigen::Matrix3d R = state.R_map_body.matrix();
  const Eigen::Matrix3d arm = geometry::skew(imu);
  const Eigen::Vector3d velocity = R.transpose() * state.velocity;
  BaseMotion result;
  result.T_map_base = state.T_map_body() * T_body_base();
  result.twist << velocity - estimate.angular_rate.cross(imu), estimate.angular_rate;

  Jacobian pose = Jacobian::Zero();
  pose.block<3, 3>(0, estimation::kPosition).setIdentity();
  pose.block<3, 3>(0, estimation::kRotation) = R * arm;
  pose.block<3, 3>(3, estimation::kRotation) = R;
  result.pose_covariance = pose * covariance * pose.transpose();

  Jacobian twist = Jacobian::Zero();
  twist.block<3, 3>(0, estimation::kRotation) = geometry::skew(velocity);
  twist.block<3, 3>(0, estimation::kVelocity) = R.transpose();
  twist.block<3, 3>(0, estimation::kGyroBias) = -arm;
  twist.block<3, 3>(3, estimation::kGyroBias) = -Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 6, 3> rate;
  rate << arm, Eigen::Matrix3d::Identity();
  result.twist_covariance =
      twist * covariance * twist.transpose() + rate_variance * rate * rate.transpose();
  return result;
}

}  // namespace pipescout
