// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

namespace pipescout::rack_vision {

/// px of a window of grey levels across a contour, one pixel apart from inside to outside: before
/// its middle, after it, and in all.
inline constexpr int kLimbInside = 7;
inline constexpr int kLimbOutside = 5;
inline constexpr int kLimbWindow = kLimbInside + kLimbOutside + 1;

/// Grey levels squared, of what a fit leaves: quantisation is never below it.
inline constexpr float kLeastLimbVariance = 0.25F;

using LimbWindow = std::span<const float, kLimbWindow>;

/// One value per shape: a whole vector.
using PerShape = Eigen::Array4f;

/// A window less its mean.
struct CentredWindow {
  explicit CentredWindow(LimbWindow window) noexcept;

  /// With each of up to four shapes, whose values in the window these are.
  [[nodiscard]] PerShape products(const std::array<PerShape, kLimbWindow>& shapes) const noexcept {
    PerShape sums = PerShape::Zero();
    for (std::size_t i = 0; i < kLimbWindow; ++i) {
      sums += shapes[i] * values[i];
    }
    return sums;
  }

  std::array<PerShape, kLimbWindow> values;  ///< each four times, for `products`
  float energy = 0;                          ///< sum of squares
};

/// What the brightness of a round pipe consists of, `d` px within its contour, in an image that is
/// blurred by `sigma` px: 1, sqrt(d) and d, see LimbProfile. All are zero outside.
[[nodiscard]] double blurred_step(double d, double sigma);
[[nodiscard]] double blurred_root(double d, double sigma);
[[nodiscard]] double blurred_ramp(double d, double sigma);

}  // namespace pipescout::rack_vision
