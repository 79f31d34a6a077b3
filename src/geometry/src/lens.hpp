// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/geometry/camera.hpp"

/// The distortion of a lens on the plane z = 1. Not installed.
namespace pipescout::geometry {

/// Squared radius on the plane z = 1 up to which the distortion is monotonic and valid.
[[nodiscard]] double largest_squared_radius(const CameraParameters& camera);

/// The point as the lens shows it, with the derivative where that is asked for.
[[nodiscard]] Eigen::Vector2d distort_plane(const CameraParameters& camera,
                                            const Eigen::Vector2d& point,
                                            Eigen::Matrix2d* derivative);

/// The inverse within `squared_limit`, as `largest_squared_radius`; nothing beyond it.
[[nodiscard]] std::optional<Eigen::Vector2d> undistort_plane(const CameraParameters& camera,
                                                             const Eigen::Vector2d& distorted,
                                                             double squared_limit);

}  // namespace pipescout::geometry
