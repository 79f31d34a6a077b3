// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/geometry/camera.hpp"

namespace pipescout::rack_vision {

/// Ideal px in this direction, a unit vector, to a px of the image: 1 for a lens without
/// distortion, and where the ideal pixel is not seen.
[[nodiscard]] double ideal_per_pixel(const geometry::Camera& camera, const Eigen::Vector2d& ideal,
                                     const Eigen::Vector2d& direction);

/// The same, the root of the ratio of areas.
[[nodiscard]] double ideal_per_pixel(const geometry::Camera& camera, const Eigen::Vector2d& ideal);

}  // namespace pipescout::rack_vision
