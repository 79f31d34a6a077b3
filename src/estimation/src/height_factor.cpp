// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/height_factor.hpp"

#include <cmath>

#include "measurement_check.hpp"

namespace pipescout::estimation {

using geometry::skew;

InputFault check(const HeightMeasurement& m) noexcept {
  return verdict(
      finite({m.time, m.height, m.standard_deviation}) && m.sensor.allFinite() && m.bias < kOwnSize,
      is_deviation(m.standard_deviation));
}

void add_values(const HeightMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.height);
}

double pressure_height(double pressure) noexcept {
  // The troposphere of the ISO standard atmosphere: T0 / L (1 - (p / p0)^(R L / g)).
  constexpr double kPressure = 101325;     // Pa
  constexpr double kScale = 44330.769;     // m, 288.15 K / 6.5 K/km
  constexpr double kExponent = 0.1902632;  // of dry air
  return kScale * (1 - std::pow(pressure / kPressure, kExponent));
}

HeightFactor::HeightFactor(const HeightMeasurement& measurement) : WhitenedFactor(measurement) {
  whitening_(0, 0) = 1 / measurement.standard_deviation;
}

HeightFactor::Residual HeightFactor::evaluate(const NavState& x, const GlobalStates& globals,
                                              Derivatives* derivatives) const {
  const double sharpness = whitening_(0, 0);
  const Eigen::Vector3d point = x.position + x.R_map_body * measurement_.sensor;
  const bool biased = measurement_.bias >= 0;
  if (derivatives != nullptr) {
    derivatives->from(0, kPosition + 2) = sharpness;
    derivatives->from.middleCols<3>(kRotation) =
        -sharpness * (x.R_map_body.matrix() * skew(measurement_.sensor)).row(2);
    if (biased) {
      derivatives->globals(0, kOwnStates + measurement_.bias) = sharpness;
    }
  }
  const double bias = biased ? globals.own[measurement_.bias] : 0;
  return Residual(sharpness * (point.z() + bias - measurement_.height));
}

}  // namespace pipescout::estimation
