// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "first_pose_evidence.hpp"
#include "first_pose_pencil.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/first_pose.hpp"

namespace pipescout::rack_vision::internal {

/// Proposes poses from pencils and resections, refines the best on all edges of the model, and says
/// whether one of them stands out. Throws std::invalid_argument when no two pipes run along y.
[[nodiscard]] FirstPose search_first_pose(const FirstPoseParameters& parameters,
                                          const RackOutline& rack, const geometry::Camera& camera,
                                          const FirstPoseHint& hint,
                                          std::span<const SegmentPlane> planes);

}  // namespace pipescout::rack_vision::internal
