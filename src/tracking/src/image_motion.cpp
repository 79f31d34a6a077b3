// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/image_motion.hpp"

#include <cmath>

namespace pipescout::tracking {

geometry::Vector6d camera_velocity(const geometry::SE3& T_body_camera,
                                   const geometry::Vector6d& body_velocity) {
  return T_body_camera.inverse().adjoint() * body_velocity;
}

std::optional<ImageMotion> image_motion(const geometry::Camera& camera, const Eigen::Vector2d& at,
                                        double depth, const geometry::Vector6d& velocity) {
  if (!(depth > 0) || !std::isfinite(depth) || !at.allFinite() || !velocity.allFinite()) {
    return std::nullopt;
  }
  const Eigen::Vector3d ray = camera.inverse_matrix() * at.homogeneous();
  const double x = ray.x();
  const double y = ray.y();
  const Eigen::Vector3d v = velocity.head<3>() / depth;
  const Eigen::Vector3d w = velocity.tail<3>();
  // On the plane z = 1, 1/s.
  const Eigen::Vector2d on_plane(
      -v.x() + x * v.z() + x * y * w.x() - (1 + x * x) * w.y() + y * w.z(),
      -v.y() + y * v.z() + (1 + y * y) * w.x() - x * y * w.y() - x * w.z());
  Eigen::Matrix2d by_place;
  by_place << v.z() + y * w.x() - 2 * x * w.y(), x * w.x() + w.z(),  //
      -y * w.y() - w.z(), v.z() + 2 * y * w.x() - x * w.y();
  const Eigen::Matrix2d to_pixels = camera.matrix().topLeftCorner<2, 2>();
  return ImageMotion{at, to_pixels * on_plane, to_pixels * by_place * to_pixels.inverse()};
}

}  // namespace pipescout::tracking
