// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"

namespace pipescout::rack_vision {

/// Finite, symmetric, positive definite.
[[nodiscard]] bool is_covariance(const geometry::Matrix6d& matrix);

/// What the points of the map are wrong by together: the error of the poses from which they were
/// made, see MapErrorPrior. Its mean is zero: the map is corrected by what is found.
struct MapErrorBelief {
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();  ///< zero: there is not a map
  geometry::Matrix6d with_pose = geometry::Matrix6d::Zero();   ///< rows: pose; columns: map error

  [[nodiscard]] bool exists() const noexcept { return covariance(0, 0) > 0; }
};

/// Pose and velocity of a camera and the error of the map with their joint covariance, for constant
/// velocity disturbed by white accelerations. Errors of the pose are as in
/// geometry_msgs/PoseWithCovariance (position along the rack's axes, rotation about the rack's
/// fixed axes), those of the velocity likewise.
class PoseBelief {
 public:
  PoseBelief() = default;
  /// At this pose, with a velocity of which nothing is known but its usual size.
  PoseBelief(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);
  /// At another pose that has nothing to do with the one before; the map stays.
  void restart(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);

  /// `acceleration_sigma` m/s^2, `angular_acceleration_sigma` rad/s^2; dt in s.
  void predict(double dt, double acceleration_sigma, double angular_acceleration_sigma);
  /// By a measured motion: camera frame now -> camera frame before, its covariance as a right
  /// perturbation. dt in s, > 0: for the velocity.
  void predict(const geometry::SE3& T_previous_current, const geometry::Matrix6d& covariance,
               double dt);
  /// After a measurement that led from the predicted pose to this posterior, prior included.
  /// Without `map` it had nothing to do with the map, and how pose and map hang together is
  /// forgotten.
  void update(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance,
              const std::optional<MapErrorSolution>& map);
  /// A map is begun from this pose: their errors are one, but along y.
  void begin_map();

  [[nodiscard]] const geometry::SE3& pose() const noexcept { return pose_; }
  [[nodiscard]] geometry::Matrix6d covariance() const { return covariance_.topLeftCorner<6, 6>(); }
  [[nodiscard]] MapErrorBelief map() const;
  /// Of the pose against the map.
  [[nodiscard]] geometry::Matrix6d relative_covariance() const;
  /// [m/s along the rack's axes; rad/s about them]
  [[nodiscard]] const geometry::Vector6d& velocity() const noexcept { return velocity_; }
  [[nodiscard]] geometry::Matrix6d velocity_covariance() const {
    return covariance_.block<6, 6>(6, 6);
  }
  /// Another place along y, of the same uncertainty.
  void shift_along(double y);
  /// Another pose, as by `moved_pose`, of the same uncertainty and speed.
  void shift(const geometry::Vector6d& difference);

 private:
  void drift_map(double dt);
  /// After a measurement of N coordinates that moved them by `step`; `of_velocity`: covariance of
  /// the velocity with them. Returns that after it.
  template <int N>
  Eigen::Matrix<double, 6, N> learn_velocity(const Eigen::Matrix<double, N, N>& prior,
                                             const Eigen::Matrix<double, N, N>& posterior,
                                             const Eigen::Matrix<double, 6, N>& of_velocity,
                                             const Eigen::Matrix<double, N, 1>& step);
  /// Unrelated to the velocity.
  void set_map(const MapErrorBelief& map);

  geometry::SE3 pose_;
  geometry::Vector6d velocity_ = geometry::Vector6d::Zero();
  /// Pose, velocity, map error.
  Eigen::Matrix<double, 18, 18> covariance_ = Eigen::Matrix<double, 18, 18>::Zero();
};

/// Difference `to` minus `from` of two poses T_rack_camera, in the terms of the covariances.
[[nodiscard]] geometry::Vector6d pose_difference(const geometry::SE3& from,
                                                 const geometry::SE3& to) noexcept;

/// The pose moved by such a difference.
[[nodiscard]] geometry::SE3 moved_pose(const geometry::SE3& from,
                                       const geometry::Vector6d& difference);

}  // namespace pipescout::rack_vision
