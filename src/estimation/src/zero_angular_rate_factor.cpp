// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/zero_angular_rate_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;

InputFault check(const ZeroAngularRateMeasurement& m) noexcept {
  return verdict(finite({m.time, m.standard_deviation}) && m.angular_rate.allFinite(),
                 is_deviation(m.standard_deviation));
}

void add_values(const ZeroAngularRateMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.angular_rate);
}

ZeroAngularRateFactor::ZeroAngularRateFactor(const ZeroAngularRateMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = Matrix3d::Identity() / measurement.standard_deviation;
}

ZeroAngularRateFactor::Residual ZeroAngularRateFactor::evaluate(const NavState& x,
                                                                const GlobalStates& /*globals*/,
                                                                Derivatives* derivatives) const {
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kGyroBias) = -whitening_;
  }
  return whitening_ * (measurement_.angular_rate - x.gyro_bias);
}

}  // namespace pipescout::estimation
