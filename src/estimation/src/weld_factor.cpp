// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/weld_factor.hpp"

#include "measurement_check.hpp"
#include "point_residual.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;

InputFault check(const WeldMeasurement& m) noexcept {
  const InputFault fault =
      verdict(finite({m.time, m.along_deviation, m.across_deviation}) && m.position.allFinite() &&
                  m.sensor.allFinite() && m.direction.allFinite(),
              is_deviation(m.along_deviation) && is_deviation(m.across_deviation));
  return fault == InputFault::kNone && !is_unit(m.direction) ? InputFault::kBadDirection : fault;
}

void add_values(const WeldMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.position);
}

WeldFactor::WeldFactor(const WeldMeasurement& measurement) : MeasuredFactor(measurement) {
  const Matrix3d along = measurement.direction * measurement.direction.transpose();
  whitening_ = along / measurement.along_deviation +
               (Matrix3d::Identity() - along) / measurement.across_deviation;
}

WeldFactor::Residual WeldFactor::evaluate(const NavState& x, const GlobalStates& /*globals*/,
                                          Derivatives* derivatives) const {
  return point_residual(x, measurement_.sensor, measurement_.position, whitening_, derivatives);
}

}  // namespace pipescout::estimation
