// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

/// Weights of iteratively reweighted least squares. All are functions of e / sigma >= 0, the size
/// of a residual in standard deviations, and of a width in the same unit.
namespace pipescout::statistics {

enum class RobustKernel : std::uint8_t {
  kNone,      ///< 1: least squares
  kSaliency,  ///< nu / (nu + e): equation (29) of Lippiello and Cacace, "Robust
              ///< visual localization of a UAV over a pipe-rack based on the Lie group SE(3)",
              ///< times nu, which is the width
  kHuber,     ///< min(1, width / e)
  kCauchy,    ///< 1 / (1 + (e / width)^2)
  kTukey,     ///< (1 - (e / width)^2)^2, 0 beyond the width
};

/// Weight, derivative and cost for one residual.
struct KernelValue {
  double weight = 1;  ///< psi(e) / e, in [0, 1]
  double slope = 1;   ///< psi'(e)
  double cost = 0;    ///< rho(e), with rho' = psi and rho(0) = 0
};

/// `e` >= 0 or infinite, `width` > 0. Not checked; NaN in, NaN out.
[[nodiscard]] inline KernelValue evaluate(RobustKernel kernel, double e, double width) noexcept {
  const double ratio = e / width;
  switch (kernel) {
    case RobustKernel::kSaliency: {
      const double weight = 1 / (1 + ratio);
      return {weight, weight * weight, width * (e - width * std::log1p(ratio))};
    }
    case RobustKernel::kHuber:
      if (e > width) {
        return {width / e, 0, width * (e - 0.5 * width)};
      }
      break;
    case RobustKernel::kCauchy: {
      const double square = ratio * ratio;
      const double weight = 1 / (1 + square);
      return {weight, (1 - square) * weight * weight, 0.5 * width * width * std::log1p(square)};
    }
    case RobustKernel::kTukey: {
      const double rest = 1 - ratio * ratio;
      if (rest <= 0) {
        return {0, 0, width * width / 6};
      }
      return {rest * rest, rest * (1 - 5 * ratio * ratio),
              width * width / 6 * (1 - rest * rest * rest)};
    }
    case RobustKernel::kNone:
      break;
  }
  return {1, 1, 0.5 * e * e};
}

/// Widths with the usual efficiency: saliency 1 (the paper: "approximately one standard deviation
/// of the inliers"), Huber 1.345, Cauchy 2.385, Tukey 4.685; 1 for kNone, which has no width.
[[nodiscard]] double default_width(RobustKernel kernel) noexcept;

/// For normal residuals of standard deviation 1: E[psi^2] E[w] / E[psi']^2, by which the inverse of
/// the weighted information matrix has to be multiplied to be a covariance (Huber and Ronchetti,
/// "Robust Statistics", section 6.3). `dimensions` 1, or 2 for residuals that are norms of pairs.
[[nodiscard]] double covariance_factor(RobustKernel kernel, double width, int dimensions) noexcept;

/// "saliency", "tukey", ...; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(RobustKernel kernel) noexcept;

}  // namespace pipescout::statistics
