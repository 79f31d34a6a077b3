// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "first_pose_evidence.hpp"
#include "first_pose_pencil.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"

namespace pipescout::rack_vision::internal {

/// Places of the camera along the flow (rack y, m) at which segments across it
/// would be edges of supports and contours of pipes that cross: each segment
/// votes for each edge. The most voted ones within [low, high] first, at most
/// `most`. What `T_camera_rack` says about y is not used.
[[nodiscard]] std::vector<double> places_along(const geometry::SE3& T_camera_rack,
                                               std::span<const SegmentPlane> planes,
                                               const RackOutline& rack,
                                               const geometry::Camera& camera, double tolerance,
                                               double low, double high, std::size_t most);

/// The same pose with the camera's centre at another y.
[[nodiscard]] geometry::SE3 at_place(const geometry::SE3& T_camera_rack, double y);

}  // namespace pipescout::rack_vision::internal
