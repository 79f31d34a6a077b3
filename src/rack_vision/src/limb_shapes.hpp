// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// A window less its mean.
struct CentredWindow {
  explicit CentredWindow(LimbWindow window) noexcept;

  std::array<float, kLimbWindow> values{};
  float energy = 0;  ///< sum of squares
};

/// What the brightness of a round pipe consists of, `d` px within its contour, in an image that is
/// blurred by `sigma` px: 1, sqrt(d) and d, see LimbProfile. All are zero outside.
[[nodiscard]] double blurred_step(double d, double sigma);
[[nodiscard]] double blurred_root(double d, double sigma);
[[nodiscard]] double blurred_ramp(double d, double sigma);

}  // namespace pipescout::rack_vision
