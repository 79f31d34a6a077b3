// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/velocity_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;

InputFault check(const VelocityMeasurement& m) noexcept {
  return verdict(finite({m.time}) && m.velocity.allFinite() && m.covariance.allFinite() &&
                     m.sensor.allFinite() && m.angular_rate.allFinite(),
                 is_covariance(m.covariance));
}

void add_values(const VelocityMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.velocity);
}

VelocityFactor::VelocityFactor(const VelocityMeasurement& measurement)
    : WhitenedFactor(measurement) {
  whitening_ = whitening_of(measurement.covariance);
}

VelocityFactor::Residual VelocityFactor::evaluate(const NavState& x,
                                                  const GlobalStates& /*globals*/,
                                                  Derivatives* derivatives) const {
  const Vector3d swing = (measurement_.angular_rate - x.gyro_bias).cross(measurement_.sensor);
  if (derivatives != nullptr) {
    const Matrix3d turned = whitening_ * x.R_map_body.matrix();
    derivatives->from.middleCols<3>(kRotation) = -turned * skew(swing);
    derivatives->from.middleCols<3>(kVelocity) = whitening_;
    derivatives->from.middleCols<3>(kGyroBias) = turned * skew(measurement_.sensor);
  }
  return whitening_ * (x.velocity + x.R_map_body * swing - measurement_.velocity);
}

}  // namespace pipescout::estimation
