// SPDX-License-Identifier: Apache-2.0
#include "limb_pair.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "limb_profile.hpp"
#include "thin_qr.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kLeastLeft = 4;  // grey levels squared: noise alone leaves as much
constexpr double kWorth = 20;     // by which chi-square has to fall for three unknowns more
// Of a step: smaller ones are what the shapes do not say of the pipe's shading.
constexpr float kLeastStep = 6;          // grey levels
constexpr float kLeastShareStep = 0.1F;  // of the border's
constexpr double kLeastSigma = 0.1;      // px
constexpr double kUsualSigma = 0.2;      // px, where the places that were tried do not tell

}  // namespace

LimbPair::LimbPair(double blur_sigma) : places_(static_cast<std::size_t>(kContours * kGaps)) {
  for (int k = 0; k < kContours * kGaps; ++k) {
    const double contour = kFirst + kStep * (k / kGaps);
    const double gap = kLeastGap + kGapStep * (k % kGaps);
    Eigen::Matrix<double, kLimbWindow, kShapes + 1> shapes;
    for (int i = 0; i < kLimbWindow; ++i) {
      const double d = contour - (i - kLimbInside);
      shapes.row(i) << 1, blurred_root(d, blur_sigma), blurred_ramp(d, blur_sigma),
          blurred_step(d + gap, blur_sigma), blurred_step(d, blur_sigma);
    }
    const auto [q, r] = ThinQr(shapes);
    Places& table = places_[static_cast<std::size_t>(k)];
    for (int i = 0; i < kLimbWindow; ++i) {
      table.shapes[static_cast<std::size_t>(i)] = q.row(i).tail<kShapes>().cast<float>().array();
    }
    table.contour_step = static_cast<float>(1 / r(4, 4));
    table.border_step = static_cast<float>(1 / r(3, 3));
    table.border_by_contour = static_cast<float>(r(3, 4) / r(3, 3));
  }
}

std::optional<LimbPair::Fit> LimbPair::fit(LimbWindow window, double left) const noexcept {
  if (left < kLeastLeft) {
    return std::nullopt;
  }
  const CentredWindow centred(window);
  const auto explained = [&](std::size_t places) {
    return centred.products(places_[places].shapes).square().sum();
  };
  std::size_t best = 0;
  float most = -1;
  for (std::size_t k = 0; k < places_.size(); ++k) {
    if (const float value = explained(k); value > most) {
      most = value;
      best = k;
    }
  }
  constexpr int kFreedom = kLimbWindow - kShapes - 3;
  const double left_by_pair =
      std::max(double{kLeastLimbVariance} * kFreedom, static_cast<double>(centred.energy - most));
  const double variance = left_by_pair / kFreedom;
  if (left * LimbProfile::kFreedom - left_by_pair < kWorth * variance) {
    return std::nullopt;
  }
  const PerShape sums = centred.products(places_[best].shapes);
  const float at_contour = places_[best].contour_step * sums[kShapes - 1];
  const float at_border =
      places_[best].border_step * sums[kShapes - 2] - places_[best].border_by_contour * at_contour;
  if (std::abs(at_contour) < std::max(kLeastStep, kLeastShareStep * std::abs(at_border)) ||
      std::abs(at_border) < kLeastStep) {
    return std::nullopt;
  }
  const int contour = static_cast<int>(best) / kGaps;
  const int gap = static_cast<int>(best) % kGaps;
  Fit fit;
  fit.contour = kFirst + kStep * contour;
  fit.border = fit.contour + kLeastGap + kGapStep * gap;
  fit.sigma = kUsualSigma;
  if (contour > 0 && contour + 1 < kContours) {
    const float before = explained(best - kGaps);
    const float after = explained(best + kGaps);
    if (const double bend = before - 2 * most + after; bend < 0) {
      fit.contour += kStep * std::clamp(0.5 * (before - after) / bend, -1.0, 1.0);
      // -bend / 2 is the information about the place, times the variance, per step squared.
      fit.sigma = std::max(kLeastSigma, kStep * std::sqrt(-2 * variance / bend));
    }
  }
  return fit;
}

}  // namespace pipescout::rack_vision
