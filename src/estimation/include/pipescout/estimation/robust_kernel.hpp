// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

/// Weights of outliers in iteratively reweighted least squares, and the chi-square gate. Residuals
/// are in standard deviations.
namespace pipescout::estimation {

enum class RobustKernel : std::uint8_t {
  kNone,      ///< 1: least squares
  kHuber,     ///< min(1, width / e)
  kCauchy,    ///< 1 / (1 + (e / width)^2)
  kSaliency,  ///< width / (width + e): equation (29) of Lippiello and Cacace, "Robust visual
              ///< localization of a UAV over a pipe-rack based on the Lie group SE(3)", times nu;
              ///< nu is the width
};

struct KernelValue {
  double weight = 1;  ///< psi(e) / e, in [0, 1]
  double cost = 0;    ///< rho(e), with rho' = psi, rho(0) = 0; e^2 / 2 for kNone
};

/// `e` >= 0, `width` > 0. Not checked; NaN in, NaN out.
[[nodiscard]] KernelValue evaluate(RobustKernel kernel, double e, double width) noexcept;

/// "none", "huber", "cauchy", "saliency"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(RobustKernel kernel) noexcept;

/// The probability that a chi-square variable is at most `value`. `degrees` >= 1, `value` >= 0;
/// not checked.
[[nodiscard]] double chi_square_probability(double value, int degrees) noexcept;

/// Its inverse, within 1e-12 of its value. Throws std::invalid_argument unless `degrees` is in
/// [1, 100] and `probability` in (0, 1).
[[nodiscard]] double chi_square_quantile(double probability, int degrees);

/// Treatment of outliers among measurements of one kind.
struct Robustness {
  RobustKernel kernel = RobustKernel::kNone;
  double width = 1;  ///< standard deviations, in [1e-3, 1e3]
  /// Share of correct measurements that the gate accepts; in (0, 1], 1: no gate.
  double gate_probability = 1;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

}  // namespace pipescout::estimation
