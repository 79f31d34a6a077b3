// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/first_pose.hpp"
#include "pipescout/rack_vision/image_view.hpp"

/// Straight edges of an image, for the first pose: line segments of von Gioi, Jakubowicz, Morel and
/// Randall ("LSD: a Line Segment Detector", IPOL 2012), fitted anew to the steepest places along
/// them to a fraction of a pixel, without the lens's distortion.
namespace pipescout::rack_vision {

struct SegmentParameters {
  double shortest = 20;          ///< pixels, [8, 1000]
  double smallest_contrast = 6;  ///< mean step across, grey levels, (0, 255]
  double blur = 1.0;  ///< Gaussian standard deviation before the search, pixels, [0, 10]: it takes
                      ///< noise and texture off and leaves contours
  std::size_t most = 300;  ///< segments, the longest are kept, [4, 10000]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Segments in ideal pixels, brighter side on the right, longest first. Empty for an image without
/// edges. Throws std::invalid_argument as SegmentParameters::validate, when the view is not valid,
/// and when its size is not that of the camera. Deterministic; allocates.
[[nodiscard]] std::vector<ImageSegment> extract_segments(const ImageView& image,
                                                         const geometry::Camera& camera,
                                                         const SegmentParameters& parameters = {});

}  // namespace pipescout::rack_vision
