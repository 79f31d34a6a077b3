// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "limb_shapes.hpp"

namespace pipescout::rack_vision {

/// The contour of a round pipe and, 1 to 3 px outside of it, the border of a shadow, a stripe or
/// rust. The image blurs both into one step, of which LimbProfile finds the contour too far out.
/// So: least squares of background + step + [1, sqrt(d), d] within the contour, over the places of
/// both.
class LimbPair {
 public:
  struct Fit {
    double contour = 0;  ///< px outwards from the middle of the window
    double border = 0;   ///< the one outside of it
    double sigma = 0;    ///< px, of the contour
  };

  /// `blur_sigma`: of the image, px.
  explicit LimbPair(double blur_sigma);

  /// `left`: the variance that a contour alone leaves of the window, grey levels squared. None
  /// where that explains it about as well.
  [[nodiscard]] std::optional<Fit> fit(LimbWindow window, double left) const noexcept;

 private:
  static constexpr double kFirst = -3.5, kLast = 1.0, kStep = 0.25;  ///< px, of the contour
  static constexpr double kLeastGap = 1.25, kMostGap = 3.25, kGapStep = 0.5;  ///< px
  static constexpr int kGaps = static_cast<int>((kMostGap - kLeastGap) / kGapStep) + 1;
  static constexpr int kContours = static_cast<int>((kLast - kFirst) / kStep) + 1;
  /// Without the constant one, of which a centred window has nothing.
  static constexpr int kShapes = 4;
  static_assert(kShapes == PerShape::SizeAtCompileTime);
  /// Orthonormal shapes for two places. The last coefficient is that of the contour's step, the one
  /// before it that of the border's.
  struct Places {
    std::array<PerShape, kLimbWindow> shapes;
    float contour_step = 0;       ///< per product with the last shape
    float border_step = 0;        ///< per product with the one before it
    float border_by_contour = 0;  ///< of the border's step, what the contour's takes
  };

  std::vector<Places> places_;  ///< all gaps of a contour, contour after contour
};

}  // namespace pipescout::rack_vision
