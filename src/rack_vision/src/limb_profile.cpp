// SPDX-License-Identifier: Apache-2.0
#include "limb_profile.hpp"

#include <algorithm>
#include <cmath>

#include "thin_qr.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr int kCoarse = 4;  // steps of the first search: half a pixel

}  // namespace

LimbProfile::LimbProfile(double blur_sigma) : places_(static_cast<std::size_t>(kPlaces)) {
  for (int k = 0; k < kPlaces; ++k) {
    const double place = kFirst + static_cast<double>(k) / kSteps;
    Eigen::Matrix<double, kLimbWindow, kShapes> shapes;
    for (int i = 0; i < kLimbWindow; ++i) {
      const double d = place - (i - kLimbInside);
      shapes.row(i) << 1, blurred_root(d, blur_sigma), blurred_step(d, blur_sigma);
    }
    const Eigen::MatrixXd q = ThinQr(shapes).q;
    Place& table = places_[static_cast<std::size_t>(k)];
    for (int i = 0; i < kLimbWindow; ++i) {
      table[static_cast<std::size_t>(i)] << q.row(i).cast<float>().transpose().array(), 0;
    }
  }
}

LimbProfile::Fit LimbProfile::fit(LimbWindow window) const noexcept {
  const CentredWindow centred(window);
  int best = 0;
  float most = -1;
  for (int place = 0; place < kPlaces; place += kCoarse) {
    const float value = explained(place, centred);
    if (value > most) {
      most = value;
      best = place;
    }
  }
  for (const int step : {2, 1}) {
    for (const int place : {best - step, best + step}) {
      const float value = place >= 0 && place < kPlaces ? explained(place, centred) : -1;
      if (value > most) {
        most = value;
        best = place;
      }
    }
  }
  const int middle = std::clamp(best, 1, kPlaces - 2);
  const float before = explained(middle - 1, centred);
  const float at = explained(middle, centred);
  const float after = explained(middle + 1, centred);
  const float bend = before - 2 * at + after;
  const float variance =
      std::max(kLeastLimbVariance, (centred.energy - most) / static_cast<float>(kFreedom));
  Fit fit;
  fit.left = static_cast<double>(variance);
  double offset = 0;
  fit.sigma = kLast - kFirst;
  if (bend < 0) {
    offset = std::clamp(0.5 * static_cast<double>((before - after) / bend), -1.0, 1.0);
    // -bend / 2 is the information about the place, times the variance, per step squared.
    fit.sigma = std::min(fit.sigma, std::sqrt(2 * static_cast<double>(-variance / bend)) / kSteps);
  }
  fit.place = kFirst + (middle + offset) / kSteps;
  return fit;
}

}  // namespace pipescout::rack_vision
