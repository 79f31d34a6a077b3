// SPDX-License-Identifier: Apache-2.0
#include "pipescout/statistics/robust_kernel.hpp"

#include <cmath>

namespace pipescout::statistics {

double default_width(RobustKernel kernel) noexcept {
  switch (kernel) {
    case RobustKernel::kHuber:
      return 1.345;
    case RobustKernel::kCauchy:
      return 2.385;
    case RobustKernel::kTukey:
      return 4.685;
    case RobustKernel::kSaliency:
    case RobustKernel::kNone:
      break;
  }
  return 1;
}

double covariance_factor(RobustKernel kernel, double width, int dimensions) noexcept {
  // Midpoint rule on the density of the norm: half-normal for one dimension, Rayleigh for two. Its
  // constant cancels.
  constexpr int kSteps = 4000;
  constexpr double kEnd = 10;
  constexpr double kStep = kEnd / kSteps;
  double weight = 0, slope = 0, square = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double e = (i + 0.5) * kStep;
    const double density = std::exp(-0.5 * e * e) * (dimensions == 2 ? e : 1.0);
    const KernelValue value = evaluate(kernel, e, width);
    weight += density * value.weight;
    // The mean over the directions in which a vector of this norm may lie.
    slope += density * (dimensions == 2 ? 0.5 * (value.slope + value.weight) : value.slope);
    square += density * value.weight * value.weight * e * e / dimensions;
  }
  return square * weight / (slope * slope);
}

std::string_view to_string(RobustKernel kernel) noexcept {
  switch (kernel) {
    case RobustKernel::kNone:
      return "none";
    case RobustKernel::kSaliency:
      return "saliency";
    case RobustKernel::kHuber:
      return "huber";
    case RobustKernel::kCauchy:
      return "cauchy";
    case RobustKernel::kTukey:
      return "tukey";
  }
  return "unknown";
}

}  // namespace pipescout::statistics
