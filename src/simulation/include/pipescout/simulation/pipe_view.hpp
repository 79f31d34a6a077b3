// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"

/// The view of a straight pipe in closed form, without an image.
namespace pipescout::simulation {

struct StraightPipe {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();  ///< m, map: of its axis
  Eigen::Vector3d to = Eigen::Vector3d::UnitX();   ///< m, map
  double radius = 0.06;                            ///< m, > 0
};

/// Of its axis, between the middles of the outermost pixels.
struct PipeView {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();  ///< pixels
  Eigen::Vector2d to = Eigen::Vector2d::Zero();    ///< pixels
  double range = 0;  ///< m, from the camera to the middle, between both in the image
  /// Both edges of the pipe are in the image over its whole length: from the left to the right
  /// border, or to the ends of the pipe.
  bool whole_width = false;
};

/// Nothing when the axis is not in view, or the camera is within the pipe's radius of its axis.
/// `camera` has no distortion.
[[nodiscard]] std::optional<PipeView> view_pipe(const StraightPipe& pipe,
                                                const geometry::Camera& camera,
                                                const geometry::SE3& T_map_camera);

}  // namespace pipescout::simulation
