// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/position_factor.hpp"

#include "measurement_check.hpp"
#include "point_residual.hpp"

namespace pipescout::estimation {

InputFault check(const PositionMeasurement& m) noexcept {
  return verdict(finite({m.time}) && m.position.allFinite() && m.covariance.allFinite() &&
                     m.sensor.allFinite(),
                 is_covariance(m.covariance));
}

void add_values(const PositionMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.position);
}

PositionFactor::PositionFactor(const PositionMeasurement& measurement)
    : WhitenedFactor(measurement) {
  whitening_ = whitening_of(measurement.covariance);
}

PositionFactor::Residual PositionFactor::evaluate(const NavState& x,
                                                  const GlobalStates& /*globals*/,
                                                  Derivatives* derivatives) const {
  return point_residual(x, measurement_.sensor, measurement_.position, whitening_, derivatives);
}

}  // namespace pipescout::estimation
