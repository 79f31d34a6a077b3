// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"

/// How the image of an edge moves with the camera: Lippiello and Cacace, equations (8), (9), (15),
/// for whole lines in place of sample points.
///
/// Motions of the camera are written [dc; dphi], m and rad, as geometry_msgs/PoseWithCovariance
/// means it: its centre moves by dc along the axes of the rack, and it turns about its centre and
/// these fixed axes, R_rack_camera' = exp(dphi) R_rack_camera. That is -mu of equation (5) for a
/// rack frame whose origin is put at the camera: in contrast to mu about an origin 1 km away, its
/// six parts are of one size at any place of the rack. See `rack_motion`.
namespace pipescout::rack_vision {

using Matrix36d = Eigen::Matrix<double, 3, 6>;

/// What a pose means to lines and points, computed once for all of them.
struct CameraView {
  CameraView(const geometry::Camera& camera, const geometry::SE3& T_camera_rack) noexcept;
  /// The same for other intrinsics: `camera_matrix` is K of equation (1), upper triangular.
  CameraView(const Eigen::Matrix3d& camera_matrix, const geometry::SE3& T_camera_rack) noexcept;

  Eigen::Matrix3d matrix;         ///< K
  Eigen::Matrix3d line_matrix;    ///< K^-T R_camera_rack: planes of the rack frame to image lines
  Eigen::Matrix3d R_camera_rack;  ///< rotation of H
  Eigen::Vector3d centre;         ///< of the camera, rack frame
};

/// The line on which an edge is seen.
struct ImageLine {
  /// l over ideal pixels (u, v, 1), with |(l_0, l_1)| = 1: l . (u, v, 1) is the distance from the
  /// line in pixels, positive outside the body.
  Eigen::Vector3d line;
  /// dl / d[dc; dphi]. An offset of the edge's pipe along rack x (equation 26) moves the line as
  /// the opposite motion of the camera does: its derivative is minus the first column.
  Matrix36d derivative;
};

/// Closed form; `edge` is as `contour_lines` or `support_line` give it, for the same camera centre.
/// Returns false, and leaves `line` as it was, when the edge is seen as no line: its plane through
/// the camera is (almost) the focal plane, or the camera is on the edge.
[[nodiscard]] bool image_line(const CameraView& view, const ContourLine& edge,
                              ImageLine& line) noexcept;

/// An edge of a support as seen from `eye`. Its normal is that of the plane through eye and edge;
/// which of its sides is the outer one depends on the faces that are seen, and is not said.
/// Returns false, and leaves `edge` as it was, when the eye is on the edge's line.
[[nodiscard]] bool support_line(const SupportEdge& support_edge, const Eigen::Vector3d& eye,
                                ContourLine& edge) noexcept;

/// mu of equation (5), right perturbation of H = T_camera_rack about the rack's origin, for a
/// motion [dc; dphi] of a camera with this centre (rack frame). Linear and exact:
/// H exp(rack_motion(centre, motion)) = `moved(H, motion)`.
[[nodiscard]] geometry::Vector6d rack_motion(const Eigen::Vector3d& centre,
                                             const geometry::Vector6d& motion) noexcept;

/// H exp(mu) for that mu, without the loss of digits far from the rack's origin.
[[nodiscard]] geometry::SE3 moved(const geometry::SE3& T_camera_rack,
                                  const geometry::Vector6d& motion);

}  // namespace pipescout::rack_vision
