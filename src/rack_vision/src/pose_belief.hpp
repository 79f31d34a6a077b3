// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/geometry/se3.hpp"

namespace pipescout::rack_vision {

/// Pose and velocity of a camera with their joint covariance, for constant velocity disturbed by
/// white accelerations. Errors of the pose are as in geometry_msgs/PoseWithCovariance (position
/// along the rack's axes, rotation about the rack's fixed axes), those of the velocity likewise.
class PoseBelief {
 public:
  using Matrix12d = Eigen::Matrix<double, 12, 12>;

  PoseBelief() = default;
  /// At this pose, with a velocity of which nothing is known but its usual size.
  PoseBelief(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);

  /// `acceleration_sigma` m/s^2, `angular_acceleration_sigma` rad/s^2; dt in s.
  void predict(double dt, double acceleration_sigma, double angular_acceleration_sigma);
  /// By a measured motion: camera frame now -> camera frame before, its covariance as a right
  /// perturbation. dt in s, > 0: for the velocity.
  void predict(const geometry::SE3& T_previous_current, const geometry::Matrix6d& covariance,
               double dt);
  /// After a measurement that led from the predicted pose to this posterior, prior included.
  void update(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);

  [[nodiscard]] const geometry::SE3& pose() const noexcept { return pose_; }
  [[nodiscard]] geometry::Matrix6d covariance() const { return covariance_.topLeftCorner<6, 6>(); }
  /// [m/s along the rack's axes; rad/s about them]
  [[nodiscard]] const geometry::Vector6d& velocity() const noexcept { return velocity_; }
  /// Another place along y, of the same uncertainty.
  void shift_along(double y);
  /// Another pose, as by `moved_pose`, of the same uncertainty and speed.
  void shift(const geometry::Vector6d& difference);

 private:
  geometry::SE3 pose_;
  geometry::Vector6d velocity_ = geometry::Vector6d::Zero();
  Matrix12d covariance_ = Matrix12d::Identity();
};

/// Difference `to` minus `from` of two poses T_rack_camera, in the terms of the covariances.
[[nodiscard]] geometry::Vector6d pose_difference(const geometry::SE3& from,
                                                 const geometry::SE3& to) noexcept;

/// The pose moved by such a difference.
[[nodiscard]] geometry::SE3 moved_pose(const geometry::SE3& from,
                                       const geometry::Vector6d& difference);

}  // namespace pipescout::rack_vision
