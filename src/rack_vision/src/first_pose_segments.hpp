// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout::rack_vision::internal {

/// A straight edge in the image, ideal pixels (no distortion).
struct ImageSegment {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
};

/// Straight edges of an image of at least `shortest` pixels, longest first:
/// line segments of von Gioi, Jakubowicz, Morel and Randall ("LSD: a Line
/// Segment Detector", IPOL 2012), in an image of half the size: it shows
/// contours as well, and less texture. Not checked: the image is valid and of
/// the camera's size.
[[nodiscard]] std::vector<ImageSegment> extract_segments(const ImageView& image,
                                                         const geometry::Camera& camera,
                                                         double shortest);

}  // namespace pipescout::rack_vision::internal
