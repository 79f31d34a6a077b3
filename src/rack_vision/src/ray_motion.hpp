// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/geometry/se3.hpp"

/// How motions [dc; dphi] of the camera, in the form of the covariances of its pose, move what its
/// rays meet.
namespace pipescout::rack_vision {

using MotionRow = Eigen::Matrix<double, 1, 6>;

/// The place where a ray meets a tangent plane: its end moves by dc + dphi x from_camera, and
/// slides along the ray back into the plane.
[[nodiscard]] Eigen::Matrix<double, 3, 6> end_by_motion(const Eigen::Vector3d& from_camera,
                                                        const Eigen::Vector3d& normal) noexcept;

/// The middle of what is seen, along rack y: where the optical axis meets the level z = 0, or what
/// is straight below or above where it does not.
[[nodiscard]] MotionRow middle_by_motion(const geometry::SE3& T_rack_camera) noexcept;

}  // namespace pipescout::rack_vision
