// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/range_factor.hpp"

#include <limits>

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::RowVector3d;
using Eigen::Vector3d;
using geometry::skew;

InputFault check(const RangeMeasurement& m) noexcept {
  return verdict(finite({m.time, m.range, m.standard_deviation}) && m.beacon.allFinite() &&
                     m.sensor.allFinite() && m.bias < kOwnSize,
                 is_deviation(m.standard_deviation));
}

void add_values(const RangeMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.range).add(m.beacon);
}

RangeFactor::RangeFactor(const RangeMeasurement& measurement) : WhitenedFactor(measurement) {
  whitening_(0, 0) = 1 / measurement.standard_deviation;
}

RangeFactor::Residual RangeFactor::evaluate(const NavState& x, const GlobalStates& globals,
                                            Derivatives* derivatives) const {
  constexpr double kAtTheBeacon = 1e-3;  // m
  const double sharpness = whitening_(0, 0);
  const Vector3d away = x.position + x.R_map_body * measurement_.sensor - measurement_.beacon;
  const double distance =
      away.norm() > kAtTheBeacon ? away.norm() : std::numeric_limits<double>::quiet_NaN();
  const bool biased = measurement_.bias >= 0;
  if (derivatives != nullptr) {
    const RowVector3d direction = sharpness / distance * away.transpose();
    derivatives->from.middleCols<3>(kPosition) = direction;
    derivatives->from.middleCols<3>(kRotation) =
        -direction * x.R_map_body.matrix() * skew(measurement_.sensor);
    if (biased) {
      derivatives->globals(0, kOwnStates + measurement_.bias) = sharpness;
    }
  }
  const double bias = biased ? globals.own[measurement_.bias] : 0;
  return Residual(sharpness * (distance + bias - measurement_.range));
}

}  // namespace pipescout::estimation
