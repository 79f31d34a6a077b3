// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/contour.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace pipescout::rack_vision {
namespace {

/// Part of a line's direction vector that must lie in the image plane, relative to its norm: below
/// it the plane through the edge is the focal plane within rounding.
constexpr double kSmallestSlope = 1e-12;

}  // namespace

CameraView::CameraView(const geometry::Camera& camera, const geometry::SE3& T_camera_rack) noexcept
    : CameraView(camera.matrix(), T_camera_rack) {}

CameraView::CameraView(const Eigen::Matrix3d& camera_matrix,
                       const geometry::SE3& T_camera_rack) noexcept
    : matrix(camera_matrix),
      R_camera_rack(T_camera_rack.rotation().matrix()),
      centre(-(R_camera_rack.transpose() * T_camera_rack.translation())) {
  line_matrix = matrix.transpose().triangularView<Eigen::Lower>().solve(R_camera_rack);
}

bool image_line(const CameraView& view, const ContourLine& edge, ImageLine& line) noexcept {
  const Eigen::Vector3d direction = (edge.end - edge.start).normalized();
  const Eigen::Vector3d from_eye = edge.start - view.centre;
  const Eigen::Vector3d across = from_eye - from_eye.dot(direction) * direction;
  const double squared_distance = across.squaredNorm();  // delta^2 of equation (12)
  const Eigen::Vector3d unscaled = view.line_matrix * edge.normal;
  const double scale = unscaled.head<2>().norm();
  if (!(squared_distance > std::numeric_limits<double>::min()) ||
      !(scale > kSmallestSlope * unscaled.norm())) {
    return false;
  }
  line.line = unscaled / scale;
  // A motion of the camera by dc turns the plane about the edge, or, on a cone, to the generator
  // beside it: dn = across / delta (n . dc) / delta in both cases, as the derivative of the
  // tangency conditions n . direction of the axis = -sin, n . (axis - eye) = -radius cos shows.
  // A rotation of the camera by dphi is one of the rack, n with it, by -dphi.
  Eigen::Matrix<double, 3, 6> plane;
  plane.leftCols<3>() = (across / squared_distance) * edge.normal.transpose();
  plane.rightCols<3>() = geometry::skew(edge.normal);
  const Matrix36d raw = view.line_matrix * plane / scale;
  line.derivative = raw - line.line * (line.line.head<2>().transpose() * raw.topRows<2>());
  return true;
}

bool support_line(const SupportEdge& support_edge, const Eigen::Vector3d& eye,
                  ContourLine& edge) noexcept {
  const Eigen::Vector3d normal =
      (support_edge.end - support_edge.start).cross(support_edge.start - eye);
  const double norm = normal.norm();
  if (!(norm > std::numeric_limits<double>::min())) {
    return false;
  }
  edge = {support_edge.start, support_edge.end, normal / norm};
  return true;
}

geometry::Vector6d rack_motion(const Eigen::Vector3d& centre,
                               const geometry::Vector6d& motion) noexcept {
  geometry::Vector6d mu;
  mu.tail<3>() = -motion.tail<3>();
  mu.head<3>() = -motion.head<3>() + centre.cross(mu.tail<3>());
  return mu;
}

geometry::SE3 moved(const geometry::SE3& T_camera_rack, const geometry::Vector6d& motion) {
  const geometry::SO3 rotation = T_camera_rack.rotation() * geometry::SO3::exp(-motion.tail<3>());
  const Eigen::Vector3d centre = T_camera_rack.inverse().translation() +
                                 geometry::SO3::left_jacobian(motion.tail<3>()) * motion.head<3>();
  return {rotation, -(rotation * centre)};
}

}  // namespace pipescout::rack_vision
