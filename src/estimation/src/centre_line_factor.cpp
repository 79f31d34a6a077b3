// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/centre_line_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Vector3d;

InputFault check(const CentreLineMeasurement& m) noexcept {
  const InputFault fault = verdict(
      finite({m.time, m.standard_deviation}) && m.position.allFinite() && m.direction.allFinite(),
      is_deviation(m.standard_deviation));
  return fault == InputFault::kNone && !is_unit(m.direction) ? InputFault::kBadDirection : fault;
}

void add_values(const CentreLineMeasurement& /*m*/, Fingerprint& /*fingerprint*/) {}

CentreLineFactor::CentreLineFactor(const CentreLineMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = Eigen::Matrix2d::Identity() / measurement.standard_deviation;
  across_.row(0) = measurement.direction.unitOrthogonal().transpose();
  across_.row(1) = measurement.direction.cross(Vector3d(across_.row(0))).transpose();
}

CentreLineFactor::Residual CentreLineFactor::evaluate(const NavState& x,
                                                      const GlobalStates& /*globals*/,
                                                      Derivatives* derivatives) const {
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kPosition) = whitening_ * across_;
  }
  return whitening_ * across_ * (x.position - measurement_.position);
}

}  // namespace pipescout::estimation
