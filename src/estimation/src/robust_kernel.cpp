// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/robust_kernel.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "refuse.hpp"

namespace pipescout::estimation {

KernelValue evaluate(RobustKernel kernel, double e, double width) noexcept {
  const double ratio = e / width;
  switch (kernel) {
    case RobustKernel::kHuber:
      if (e > width) {
        return {.weight = width / e, .cost = width * (e - 0.5 * width)};
      }
      break;
    case RobustKernel::kCauchy: {
      const double square = ratio * ratio;
      return {.weight = 1 / (1 + square), .cost = 0.5 * width * width * std::log1p(square)};
    }
    case RobustKernel::kSaliency:
      return {.weight = 1 / (1 + ratio), .cost = width * (e - width * std::log1p(ratio))};
    case RobustKernel::kNone:
      break;
  }
  return {.weight = 1, .cost = 0.5 * e * e};
}

std::string_view to_string(RobustKernel kernel) noexcept {
  switch (kernel) {
    case RobustKernel::kNone:
      return "none";
    case RobustKernel::kHuber:
      return "huber";
    case RobustKernel::kCauchy:
      return "cauchy";
    case RobustKernel::kSaliency:
      return "saliency";
  }
  return "unknown";
}

double chi_square_probability(double value, int degrees) noexcept {
  // Abramowitz and Stegun, 26.4.4 and 26.4.5: finite sums for odd and for even degrees.
  const double half = 0.5 * value;
  const bool odd = degrees % 2 == 1;
  double tail = odd ? std::erfc(std::sqrt(half)) : 0;
  double term = odd ? std::sqrt(half / std::numbers::pi) * 2 * std::exp(-half) : std::exp(-half);
  for (int k = odd ? 3 : 2; k <= degrees; k += 2) {
    tail += term;
    term *= value / k;
  }
  return 1 - tail;
}

double chi_square_quantile(double probability, int degrees) {
  require("degrees", degrees, degrees >= 1 && degrees <= 100, "[1, 100]");
  require("probability", probability, probability > 0 && probability < 1, "(0, 1)");
  double low = 0;
  double high = degrees;
  while (chi_square_probability(high, degrees) < probability && high < 1e4) {
    high *= 2;
  }
  while (high - low > 1e-12 * high) {
    const double middle = 0.5 * (low + high);
    (chi_square_probability(middle, degrees) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

void Robustness::validate() const {
  require("robustness.kernel", static_cast<double>(kernel), kernel <= RobustKernel::kSaliency,
          "the kernels");
  require("robustness.width", width, width >= 1e-3 && width <= 1e3, "[1e-3, 1e3]");
  require("robustness.gate_probability", gate_probability,
          gate_probability > 0 && gate_probability <= 1, "(0, 1]");
}

}  // namespace pipescout::estimation
