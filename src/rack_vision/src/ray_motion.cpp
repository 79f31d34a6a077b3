// SPDX-License-Identifier: Apache-2.0
#include "ray_motion.hpp"

#include <cmath>

namespace pipescout::rack_vision {

Eigen::Matrix<double, 3, 6> end_by_motion(const Eigen::Vector3d& from_camera,
                                          const Eigen::Vector3d& normal) noexcept {
  Eigen::Matrix<double, 3, 6> end;
  end.leftCols<3>().setIdentity();
  end.rightCols<3>() = -geometry::skew(from_camera);
  const Eigen::Matrix3d slide =
      Eigen::Matrix3d::Identity() - from_camera * normal.transpose() / normal.dot(from_camera);
  return slide * end;
}

MotionRow middle_by_motion(const geometry::SE3& T_rack_camera) noexcept {
  constexpr double kLeastSlope = 0.2;
  constexpr int kY = 1;
  const Eigen::Vector3d axis = T_rack_camera.rotation() * Eigen::Vector3d::UnitZ();
  const double height = T_rack_camera.translation().z();
  const bool looks_at_it = axis.z() * height < -kLeastSlope * std::abs(height);
  const Eigen::Vector3d from_camera = looks_at_it ? Eigen::Vector3d(-height / axis.z() * axis)
                                                  : Eigen::Vector3d(0, 0, height < 0 ? 1 : -1);
  return end_by_motion(from_camera, Eigen::Vector3d::UnitZ()).row(kY);
}

}  // namespace pipescout::rack_vision
