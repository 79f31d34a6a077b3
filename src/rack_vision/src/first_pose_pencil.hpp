// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/first_pose.hpp"

namespace pipescout::rack_vision::internal {

/// A segment and what follows from it.
struct SegmentPlane {
  ImageSegment segment;
  Eigen::Vector3d normal;     ///< camera frame, unit: of the plane through the camera's centre
  Eigen::Vector2d direction;  ///< in the image, unit
  double length = 0;          ///< pixels
};

/// Segments of at least `shortest` pixels, without those that are not finite.
[[nodiscard]] std::vector<SegmentPlane> segment_planes(std::span<const ImageSegment> segments,
                                                       const geometry::Camera& camera,
                                                       double shortest);

/// Image line of the plane through the camera's centre with this normal: l . (u, v, 1) in pixels.
[[nodiscard]] Eigen::Vector3d image_line_of_plane(const geometry::Camera& camera,
                                                  const Eigen::Vector3d& normal);

/// Whether a segment points at the vanishing point K `direction` (which may be at infinity): at
/// most `tolerance` pixels from its middle to its end beside the line that joins the two.
[[nodiscard]] bool points_along(const SegmentPlane& plane, const Eigen::Matrix3d& camera_matrix,
                                const Eigen::Vector3d& direction, double tolerance);

/// Segments of one polarity on one line of a pencil.
struct PencilLine {
  Eigen::Vector3d normal;  ///< camera frame, unit, at right angles to the pencil's direction
  double length = 0;       ///< of its segments together, pixels
};

/// Lines of the image that are images of parallel lines.
struct Pencil {
  Eigen::Vector3d direction;      ///< of these, camera frame, unit; either sign
  std::vector<PencilLine> lines;  ///< longest first
};

/// The strongest pencils first, at most `most`, with directions that make at least 15 degrees with
/// each other and at most `largest_tilt` (rad) with the image plane.
[[nodiscard]] std::vector<Pencil> find_pencils(std::span<const SegmentPlane> planes,
                                               const geometry::Camera& camera, double largest_tilt,
                                               double tolerance, std::size_t most);

}  // namespace pipescout::rack_vision::internal
