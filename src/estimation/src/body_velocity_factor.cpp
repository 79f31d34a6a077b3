// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/body_velocity_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Vector3d;
using geometry::skew;

InputFault check(const BodyVelocityMeasurement& m) noexcept {
  return verdict(finite({m.time}) && m.velocity.allFinite() && m.covariance.allFinite() &&
                     m.sensor.allFinite() && m.angular_rate.allFinite(),
                 is_covariance(m.covariance));
}

void add_values(const BodyVelocityMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.velocity);
}

BodyVelocityFactor::BodyVelocityFactor(const BodyVelocityMeasurement& measurement)
    : WhitenedFactor(measurement) {
  whitening_ = whitening_of(measurement.covariance);
}

BodyVelocityFactor::Residual BodyVelocityFactor::evaluate(const NavState& x,
                                                          const GlobalStates& /*globals*/,
                                                          Derivatives* derivatives) const {
  const Vector3d origin = x.R_map_body.inverse() * x.velocity;
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kRotation) = whitening_ * skew(origin);
    derivatives->from.middleCols<3>(kVelocity) = whitening_ * x.R_map_body.matrix().transpose();
    derivatives->from.middleCols<3>(kGyroBias) = whitening_ * skew(measurement_.sensor);
  }
  const Vector3d swing = (measurement_.angular_rate - x.gyro_bias).cross(measurement_.sensor);
  return whitening_ * (origin + swing - measurement_.velocity);
}

}  // namespace pipescout::estimation
