// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/body_motion.hpp"

#include <Eigen/Geometry>

#include "pipescout/simulation/uav.hpp"

namespace pipescout::simulation {

Eigen::Vector3d BodyMotion::specific_force() const noexcept {
  return T_map_body.rotation().inverse() * (acceleration + kGravity * Eigen::Vector3d::UnitZ());
}

BodyMotion BodyMotion::of(const geometry::SE3& T_body_frame) const noexcept {
  const geometry::SO3& R_map_body = T_map_body.rotation();
  const geometry::SO3 R_frame_body = T_body_frame.rotation().inverse();
  const Eigen::Vector3d& lever = T_body_frame.translation();
  const Eigen::Vector3d sweep = angular_rate.cross(lever);
  BodyMotion result;
  result.time = time;
  result.T_map_body = T_map_body * T_body_frame;
  result.velocity = velocity + R_map_body * sweep;
  result.acceleration =
      acceleration + R_map_body * (angular_acceleration.cross(lever) + angular_rate.cross(sweep));
  result.angular_rate = R_frame_body * angular_rate;
  result.angular_acceleration = R_frame_body * angular_acceleration;
  return result;
}

}  // namespace pipescout::simulation
