// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "first_pose_segments.hpp"
#include "pipescout/geometry/camera.hpp"

namespace pipescout::rack_vision::internal {

/// A segment and what follows from it.
struct SegmentPlane {
  ImageSegment segment;
  Eigen::Vector3d normal;     ///< camera frame, unit: of the plane through the camera's centre
  Eigen::Vector2d direction;  ///< in the image, unit
  double length = 0;          ///< pixels
};

/// Segments without those that are not finite, or points.
[[nodiscard]] std::vector<SegmentPlane> segment_planes(std::span<const ImageSegment> segments,
                                                       const geometry::Camera& camera);

/// Whether a segment points at the vanishing point K `direction` (which may be
/// at infinity): at most `tolerance` pixels from its middle to its end beside
/// the line that joins the two.
[[nodiscard]] bool points_along(const SegmentPlane& plane, const Eigen::Matrix3d& camera_matrix,
                                const Eigen::Vector3d& direction, double tolerance);

/// Directions of parallel lines, camera frame, unit, of either sign, those of
/// most length first, at most `most`: they make at least 15 degrees with each
/// other and at most `largest_tilt` (rad) with the image plane.
[[nodiscard]] std::vector<Eigen::Vector3d> find_pencils(std::span<const SegmentPlane> planes,
                                                        const geometry::Camera& camera,
                                                        double largest_tilt, double tolerance,
                                                        std::size_t most);

}  // namespace pipescout::rack_vision::internal
