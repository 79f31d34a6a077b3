// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/zero_velocity_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;

InputFault check(const ZeroVelocityMeasurement& m) noexcept {
  return verdict(finite({m.time, m.standard_deviation}), is_deviation(m.standard_deviation));
}

void add_values(const ZeroVelocityMeasurement& /*m*/, Fingerprint& /*fingerprint*/) {}

ZeroVelocityFactor::ZeroVelocityFactor(const ZeroVelocityMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = Matrix3d::Identity() / measurement.standard_deviation;
}

ZeroVelocityFactor::Residual ZeroVelocityFactor::evaluate(const NavState& x,
                                                          const GlobalStates& /*globals*/,
                                                          Derivatives* derivatives) const {
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kVelocity) = whitening_;
  }
  return whitening_ * x.velocity;
}

}  // namespace pipescout::estimation
