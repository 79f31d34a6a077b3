// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "first_pose_slopes.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/so3.hpp"

namespace pipescout::rack_vision::internal {

/// Pixels of an edge that are judged as one piece.
inline constexpr double kPieceLength = 48;

/// Whether a step is one, from 0 to 1; one beside the place counts less.
[[nodiscard]] double clearness(const PieceFit& fit) noexcept;

/// What it says for a contour, nats, that `share` of the `pixels` of it that
/// are visible was found: logarithm of how much more likely that is of a
/// contour than by chance. All pieces of a contour have one reason, so a whole
/// contour says no more than that a line by chance lies there, which is so for
/// `line_share` of all places.
[[nodiscard]] double evidence_of_contour(double share, double pixels, double line_share) noexcept;

/// The image seen along the flow: what says that there is an edge along the
/// flow, as a function of its bearing. A bearing is given as its slope, the
/// tangent of the angle between straight down and the plane through the edge
/// and the camera's centre; it grows to the right.
class LineProfile {
 public:
  /// Pixels, in the middle of the image, from which a level takes the best.
  static constexpr std::array<int, 4> kReach{10, 5, 2, 1};

  /// `R_nominal`: camera from rack, of a camera without roll about the flow.
  /// All bearings that the image shows are sampled.
  LineProfile(const SlopeImage& image, const geometry::Camera& camera,
              const geometry::SO3& R_nominal);

  /// Nats for an edge within kReach[level] of this bearing; 0 where the image
  /// shows nothing.
  [[nodiscard]] float evidence(double slope, std::size_t level) const noexcept {
    const double at = (slope + kWidest) * bins_per_slope_ + 0.5;
    return at >= 0 && at < static_cast<double>(levels_[level].size())
               ? levels_[level][static_cast<std::size_t>(at)]
               : 0.0F;
  }
  /// What the image between two contours of one pipe says for a pipe being
  /// there, nats: few lines along the flow are seen on pipes, and none through
  /// them.
  [[nodiscard]] double evidence_on_pipe(double left, double right) const noexcept;
  /// Of the bearings that the image shows, those with a line within a pixel.
  [[nodiscard]] double line_share() const noexcept { return line_share_; }

 private:
  static constexpr double kWidest = 2;  // 63 degrees

  double bins_per_slope_;
  std::array<std::vector<float>, kReach.size()> levels_;
  std::vector<double> lines_;  ///< their clearness, summed up to each bin
  std::vector<double> seen_;   ///< bins that the image shows, up to each
  double line_share_ = 0;
};

}  // namespace pipescout::rack_vision::internal
