// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/rack_vision/contour.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"

/// How the contours of a pipe move with its shape.
namespace pipescout::rack_vision {

/// px along `normal`, a unit vector, from an ideal pixel to the contour of this pipe. Nothing where
/// the camera does not see that contour.
[[nodiscard]] std::optional<double> distance_to_contour(const Pipe& pipe, const EdgeId& edge,
                                                        const CameraView& view,
                                                        const Eigen::Vector2d& pixel,
                                                        const Eigen::Vector2d& normal);

/// Derivative of that distance with respect to the shape, px/m and px/rad, where the pipe has shape
/// `at`. Zero where the camera does not see the contour.
[[nodiscard]] ShapeVector distance_by_shape(const Pipe& pipe, const ShapeVector& at,
                                            const EdgeId& edge, const CameraView& view,
                                            const Eigen::Vector2d& pixel,
                                            const Eigen::Vector2d& normal);

}  // namespace pipescout::rack_vision
