// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "first_pose_evidence.hpp"
#include "first_pose_pencil.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/so3.hpp"

/// Place and roll of a camera seen along the pipes. In that plane pipes are circles, lines of the
/// image are bearings, and contours are tangents: n . (o - c) = t r with the camera at o, a circle
/// (c, r), n the normal of the bearing that points to the left (n_x < 0), and t = 1 for the left
/// contour, -1 for the right one. Three bearings i, j, k through one point o make
///     sum over cyclic i, j, k of (n_j x n_k) (n_i . c_i + t_i r_i) = 0,
/// where a roll of the camera turns all n alike and leaves their cross products: an equation
/// A cos(roll) + B sin(roll) = C in one unknown.
namespace pipescout::rack_vision::internal {

/// A section of a pipe along the flow, cut across.
struct PipeCircle {
  Eigen::Vector2d centre;  ///< rack x and z, m
  double radius = 0;       ///< m
  std::size_t rank = 0;    ///< of its pipe from left to right
};

/// Circles of the pipes along the flow, by rank; a reducer as what it is halfway. Throws
/// std::invalid_argument when there are fewer than two such pipes.
[[nodiscard]] std::vector<PipeCircle> pipe_circles(const RackOutline& rack);

/// Where the camera may be, rack frame, m and rad.
struct ResectionLimits {
  double x_low = 0, x_high = 0, z_low = 0, z_high = 0;
  double largest_roll = 0;  ///< about the flow, against the camera looking straight down
};

struct Resection {
  double x = 0, z = 0;  ///< of the camera, rack frame, m
  double roll = 0;      ///< R_camera_rack = R_nominal about_y(roll)
  double score = 0;     ///< pixels of lines on contours, less half of those that are missing
};

/// R_camera_rack of a camera that sees the flow in this direction (camera frame, unit) and has no
/// roll about it.
[[nodiscard]] geometry::SO3 nominal_rotation(const Eigen::Vector3d& flow);

/// All assignments of three of the longest `most_lines` lines to contours in their order from left
/// to right, two of which are those of one pipe with little between them; the best `most` that
/// differ, best first.
[[nodiscard]] std::vector<Resection> resections(std::span<const PencilLine> lines,
                                                const geometry::SO3& R_nominal,
                                                std::span<const PipeCircle> circles,
                                                const geometry::Camera& camera,
                                                const ResectionLimits& limits, double tolerance,
                                                std::size_t most_lines, std::size_t most);

}  // namespace pipescout::rack_vision::internal
