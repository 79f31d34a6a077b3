// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/geometry/se3.hpp"

namespace pipescout::simulation {

/// The true motion of a rigid body at one time, and the readings of ideal inertial sensors on it.
/// `map`: at rest, z up. SI units and radians.
struct BodyMotion {
  double time = 0;  ///< s
  geometry::SE3 T_map_body{};
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();              ///< m/s, map, of the origin
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();          ///< m/s^2, map, of the origin
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();          ///< rad/s, body
  Eigen::Vector3d angular_acceleration = Eigen::Vector3d::Zero();  ///< rad/s^2, body

  /// Reading of an ideal accelerometer at the origin: R^T (acceleration + g e_z), m/s^2, body, with
  /// g = `kGravity`.
  [[nodiscard]] Eigen::Vector3d specific_force() const noexcept;

  /// The motion of a frame that is fixed to the body.
  [[nodiscard]] BodyMotion of(const geometry::SE3& T_body_frame) const noexcept;
};

}  // namespace pipescout::simulation
