// SPDX-License-Identifier: Apache-2.0
#include "rack_thermal_radiometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pipescout::simulation::internal {
namespace {

constexpr double kLowest = -100;  // degC
constexpr double kHighest = 700;
constexpr double kStep = 0.5;
constexpr double kKelvin = 273.15;
constexpr double kShortest = 8e-6;  // m, of the band
constexpr double kLongest = 14e-6;
constexpr int kIntervals = 60;  // of Simpson's rule: exact to 1e-7 of the integral
// CODATA 2018.
constexpr double kPlanck = 6.62607015e-34;
constexpr double kLightSpeed = 299792458;
constexpr double kBoltzmann = 1.380649e-23;

double spectral(double wavelength, double kelvin) {
  const double exponent = kPlanck * kLightSpeed / (wavelength * kBoltzmann * kelvin);
  return 2 * kPlanck * kLightSpeed * kLightSpeed / (std::pow(wavelength, 5) * std::expm1(exponent));
}

double integral(double celsius) {
  const double width = (kLongest - kShortest) / kIntervals;
  double sum = 0;
  for (int i = 0; i <= kIntervals; ++i) {
    const double weight = i == 0 || i == kIntervals ? 1 : i % 2 == 1 ? 4 : 2;
    sum += weight * spectral(kShortest + i * width, celsius + kKelvin);
  }
  return sum * width / 3;
}

}  // namespace

BandRadiance::BandRadiance() {
  for (double celsius = kLowest; celsius <= kHighest; celsius += kStep) {
    table_.push_back(integral(celsius));
  }
}

double BandRadiance::of(double celsius) const noexcept {
  const double place = (std::clamp(celsius, kLowest, kHighest) - kLowest) / kStep;
  const std::size_t i = std::min(static_cast<std::size_t>(place), table_.size() - 2);
  return std::lerp(table_[i], table_[i + 1], place - static_cast<double>(i));
}

double BandRadiance::temperature(double radiance) const noexcept {
  const auto above = std::upper_bound(table_.begin() + 1, table_.end() - 1, radiance);
  const auto below = above - 1;
  const double share = std::clamp((radiance - *below) / (*above - *below), 0.0, 1.0);
  return kLowest + kStep * (static_cast<double>(below - table_.begin()) + share);
}

}  // namespace pipescout::simulation::internal
