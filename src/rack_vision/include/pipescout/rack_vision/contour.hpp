// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"

/// Image Jacobian of an edge with respect to the camera motion: Lippiello and Cacace, equations
/// (8), (9), (15), for whole lines instead of sample points.
///
/// Motions of the camera are written [dc; dphi], m and rad, as in geometry_msgs/PoseWithCovariance:
/// its centre moves by dc along the axes of the rack, and it rotates about its centre and these
/// fixed axes, R_rack_camera' = exp(dphi) R_rack_camera. That is -mu of equation (5) for a rack
/// frame with its origin at the camera: unlike mu about an origin 1 km away, its six parts have the
/// same magnitude at any position of the rack. See `rack_motion`.
namespace pipescout::rack_vision {

using Matrix36d = Eigen::Matrix<double, 3, 6>;

/// Quantities that depend on the pose only, computed once for all lines and points.
struct CameraView {
  CameraView(const geometry::Camera& camera, const geometry::SE3& T_camera_rack) noexcept;
  /// The same for other intrinsics: `camera_matrix` is K of equation (1), upper triangular.
  CameraView(const Eigen::Matrix3d& camera_matrix, const geometry::SE3& T_camera_rack) noexcept;

  Eigen::Matrix3d matrix;         ///< K
  Eigen::Matrix3d line_matrix;    ///< K^-T R_camera_rack: planes of the rack frame to image lines
  Eigen::Matrix3d R_camera_rack;  ///< rotation of H
  Eigen::Vector3d centre;         ///< of the camera, rack frame
};

/// The image line of an edge.
struct ImageLine {
  /// l over ideal pixels (u, v, 1), with |(l_0, l_1)| = 1: l . (u, v, 1) is the distance from the
  /// line in pixels, positive outside the body.
  Eigen::Vector3d line;
  /// dl / d[dc; dphi]. An offset of the edge's pipe along rack x (equation 26) moves the line like
  /// the opposite motion of the camera: its derivative is minus the first column.
  Matrix36d derivative;
};

/// Closed form; `edge` is a result of `contour_lines` or `support_line` for the same camera centre.
/// Returns false, and does not change `line`, when the edge has no image line: its plane through
/// the camera is (almost) the focal plane, or the camera is on the edge.
[[nodiscard]] bool image_line(const CameraView& view, const ContourLine& edge,
                              ImageLine& line) noexcept;

/// An edge of a support as seen from `eye`. Its normal is that of the plane through eye and edge;
/// which of its sides is the outer one depends on the visible faces, and is not determined. Returns
/// false, and does not change `edge`, when the eye is on the edge's line.
[[nodiscard]] bool support_line(const SupportEdge& support_edge, const Eigen::Vector3d& eye,
                                ContourLine& edge) noexcept;

/// mu of equation (5), right perturbation of H = T_camera_rack about the rack's origin, for a
/// motion [dc; dphi] of a camera with this centre (rack frame). Linear and exact:
/// H exp(rack_motion(centre, motion)) = `moved(H, motion)`.
[[nodiscard]] geometry::Vector6d rack_motion(const Eigen::Vector3d& centre,
                                             const geometry::Vector6d& motion) noexcept;

/// H exp(mu) for that mu, without loss of precision far from the rack's origin.
[[nodiscard]] geometry::SE3 moved(const geometry::SE3& T_camera_rack,
                                  const geometry::Vector6d& motion);

}  // namespace pipescout::rack_vision
