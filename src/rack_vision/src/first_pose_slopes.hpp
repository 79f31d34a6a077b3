// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout::rack_vision::internal {

/// Where a straight step of brightness was found beside a short piece of a
/// line.
struct PieceFit {
  double coherence = 0;  ///< |sum of slopes across| / sum of their sizes: 1 a
                         ///< clean step, 0 texture
  double offset = 0;     ///< pixels across, of the best place
};

/// Slopes of the blurred image, for straight edges: along one they all have one
/// sign, in texture they have not. Lines are those of the ideal image.
class SlopeImage {
 public:
  static constexpr int kLargestReach = 6;

  /// `image` must be valid and of the camera's size.
  SlopeImage(const ImageView& image, const geometry::Camera& camera);

  /// The most coherent step within `reach` pixels (0 to kLargestReach) to both
  /// sides of the piece from `start` to `end`, ideal pixels; positive offsets
  /// lie along `across`, a unit vector at right angles. Nothing when the piece
  /// is not in the image.
  [[nodiscard]] std::optional<PieceFit> fit(const Eigen::Vector2d& start,
                                            const Eigen::Vector2d& end,
                                            const Eigen::Vector2d& across, int reach) const;

 private:
  struct Slope {
    float u, v;
  };
  const geometry::Camera& camera_;
  int width_;
  int height_;
  std::vector<Slope> slopes_;
};

}  // namespace pipescout::rack_vision::internal
