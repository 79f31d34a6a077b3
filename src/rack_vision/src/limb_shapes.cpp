// SPDX-License-Identifier: Apache-2.0
#include "limb_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace pipescout::rack_vision {
namespace {

constexpr double kRadius = 40;  // px, of a usual pipe: it bends the root a little

/// Mean of f(d - u) over a Gaussian u.
template <typename Function>
double blurred(double d, double sigma, const Function& f) {
  constexpr int kHalf = 40;
  double sum = 0;
  double weights = 0;
  for (int i = -kHalf; i <= kHalf; ++i) {
    const double u = 4.0 * i / kHalf;
    const double weight = std::exp(-0.5 * u * u);
    sum += weight * f(d - u * sigma);
    weights += weight;
  }
  return sum / weights;
}

}  // namespace

CentredWindow::CentredWindow(LimbWindow window) noexcept {
  float mean = 0;
  for (const float value : window) {
    mean += value;
  }
  mean /= static_cast<float>(kLimbWindow);
  for (std::size_t i = 0; i < kLimbWindow; ++i) {
    const float value = window[i] - mean;
    values[i].setConstant(value);
    energy += value * value;
  }
}

double blurred_step(double d, double sigma) {
  return 0.5 * std::erfc(-d / (sigma * std::numbers::sqrt2));
}

double blurred_root(double d, double sigma) {
  return blurred(d, sigma, [](double x) { return x > 0 ? std::sqrt(x * (2 * kRadius - x)) : 0.0; });
}

double blurred_ramp(double d, double sigma) {
  return blurred(d, sigma, [](double x) { return std::max(x, 0.0); });
}

}  // namespace pipescout::rack_vision
