// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/position_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using geometry::skew;

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
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kPosition) = whitening_;
    derivatives->from.middleCols<3>(kRotation) =
        -whitening_ * x.R_map_body.matrix() * skew(measurement_.sensor);
  }
  return whitening_ * (x.position + x.R_map_body * measurement_.sensor - measurement_.position);
}

}  // namespace pipescout::estimation
