// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "limb_shapes.hpp"

namespace pipescout::rack_vision {

/// The grey levels across the contour of a round pipe. The surface turns away from the light
/// towards its contour: at a depth d within it, brightness goes as 1, sqrt(d) and d (the normal of
/// a cylinder at 1 - d / r of its radius, to first order). The root is so steep at the contour that
/// the steepest place of a blurred image of a bright pipe lies a pixel and more inside, where there
/// may be no step at the contour at all. So: least squares of
/// background + [1, sqrt(d)] within, blurred, over the place of the contour. With d it would be a
/// little more true on lit flanks, and so much less certain that starts fail.
class LimbProfile {
 public:
  /// How far from the middle of the window the contour is looked for, px outwards.
  static constexpr double kFirst = -1.5;
  static constexpr double kLast = 3.0;
  static constexpr int kShapes = 3;
  static constexpr int kFreedom = kLimbWindow - kShapes - 1;  ///< of what the fit leaves

  struct Fit {
    double place = 0;  ///< of the contour, px outwards from the middle of the window
    double sigma = 0;  ///< its standard deviation, from what the fit leaves, px
    double left = 0;   ///< variance of what the fit leaves, grey levels squared
  };

  /// `blur_sigma`: of the image, px.
  explicit LimbProfile(double blur_sigma);

  [[nodiscard]] Fit fit(LimbWindow window) const noexcept;

 private:
  static constexpr int kSteps = 8;  ///< of the place, per px
  static constexpr int kPlaces = static_cast<int>((kLast - kFirst) * kSteps) + 1;
  static_assert(kShapes < PerShape::SizeAtCompileTime);
  /// Orthonormal shapes for one place of the contour, and one that is zero.
  using Place = std::array<PerShape, kLimbWindow>;

  [[nodiscard]] float explained(int place, const CentredWindow& window) const noexcept {
    return window.products(places_[static_cast<std::size_t>(place)]).square().sum();
  }

  std::vector<Place> places_;
};

}  // namespace pipescout::rack_vision
