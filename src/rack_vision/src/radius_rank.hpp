// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "alignment_search.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout::rack_vision {

/// Whether a pipe in an image has the radius that the rack file gives it: a judge of a pose that
/// shares nothing with its solver. Pipes of another rack can be put so that one contour of each
/// lies on an edge of the image, and texture bears out the other one; but there pipes of most other
/// radii look as good.
class RadiusRank {
 public:
  explicit RadiusRank(const geometry::Camera& camera) : camera_(camera) {}
  /// Another camera of the same size, from now on.
  void set_camera(const geometry::Camera& camera) { camera_ = camera; }

  /// Share of other radii whose contours, at the best place nearby, are as strong in the image as
  /// those that are given, of one pipe: near 0 where it has this radius, anywhere in 0..1 where it
  /// has another one. The strength is that of the mean step in grey level across a contour: texture
  /// has candidates for edges, but no step in the mean. Nothing where too little is seen of either
  /// side, or where the pipe is too thin for other radii.
  [[nodiscard]] std::optional<double> share_of_better(
      const ImageView& image, std::span<const AlignmentContour> contours) const;

 private:
  static constexpr int kMostWider = 40;   ///< px, to either side
  static constexpr int kOtherShift = 12;  ///< px: as far as places of pipes are searched
  static constexpr int kReach = kMostWider + kOtherShift;
  static constexpr std::size_t kWidth = 2 * kReach + 1;

  struct Side {
    std::array<double, kWidth> strength{};  ///< by px outwards of where it is rendered
    double length = 0;                      ///< px
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  };

  /// Adds what is seen across a contour to its side.
  void add(const ImageView& image, const AlignmentContour& contour, Side& side) const;

  geometry::Camera camera_;
};

}  // namespace pipescout::rack_vision
