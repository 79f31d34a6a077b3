// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "first_pose_evidence.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/first_pose.hpp"
#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout::rack_vision::internal {

/// Proposes poses from the directions of pencils of lines and the profile of
/// the image along them, refines the best on all edges of the model, and says
/// whether one of them stands out. Throws std::invalid_argument when no two
/// pipes run along y. Not checked: the image is valid and of the camera's size.
[[nodiscard]] FirstPose search_first_pose(const FirstPoseParameters& parameters,
                                          const RackOutline& rack, const ImageView& image,
                                          const geometry::Camera& camera,
                                          const FirstPoseHint& hint);

}  // namespace pipescout::rack_vision::internal
