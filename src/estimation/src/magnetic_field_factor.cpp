// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/magnetic_field_factor.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::RowVector3d;
using Eigen::Vector3d;
using geometry::skew;

InputFault check(const MagneticFieldMeasurement& m) noexcept {
  const InputFault fault = verdict(finite({m.time, m.declination, m.standard_deviation}) &&
                                       m.field.allFinite() && m.bias < kOwnSize,
                                   is_deviation(m.standard_deviation));
  return fault == InputFault::kNone && !(m.field.norm() > 0) ? InputFault::kBadDirection : fault;
}

void add_values(const MagneticFieldMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.field);
}

MagneticFieldFactor::MagneticFieldFactor(const MagneticFieldMeasurement& measurement)
    : WhitenedFactor(measurement) {
  whitening_(0, 0) = 1 / measurement.standard_deviation;
  measurement_.field.normalize();
}

MagneticFieldFactor::Residual MagneticFieldFactor::evaluate(const NavState& x,
                                                            const GlobalStates& globals,
                                                            Derivatives* derivatives) const {
  constexpr double kHorizontal = 0.01;
  const double sharpness = whitening_(0, 0);
  const Vector3d field = x.R_map_body * measurement_.field;
  const double square = field.head<2>().norm() > kHorizontal
                            ? field.head<2>().squaredNorm()
                            : std::numeric_limits<double>::quiet_NaN();
  const bool biased = measurement_.bias >= 0;
  if (derivatives != nullptr) {
    const RowVector3d by_field = RowVector3d(-field.y(), field.x(), 0) / square;
    derivatives->from.middleCols<3>(kRotation) =
        -sharpness * by_field * x.R_map_body.matrix() * skew(measurement_.field);
    if (biased) {
      derivatives->globals(0, kOwnStates + measurement_.bias) = sharpness;
    }
  }
  const double bias = biased ? globals.own[measurement_.bias] : 0;
  const double north = std::numbers::pi / 2 - measurement_.declination - bias;
  const double error =
      std::remainder(std::atan2(field.y(), field.x()) - north, 2 * std::numbers::pi);
  return Residual(square > 0 ? sharpness * error : square);
}

}  // namespace pipescout::estimation
