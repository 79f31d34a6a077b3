// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/gps_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;

InputFault check(const GpsMeasurement& m) noexcept {
  return verdict(finite({m.time}) && m.position.allFinite() && m.covariance.allFinite() &&
                     m.angular_rate.allFinite(),
                 is_covariance(m.covariance));
}

void add_values(const GpsMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.position);
}

GpsFactor::GpsFactor(const GpsMeasurement& measurement) : MeasuredFactor(measurement) {
  whitening_ = whitening_of(measurement.covariance);
}

GpsFactor::Residual GpsFactor::evaluate(const NavState& x, const GlobalStates& globals,
                                        Derivatives* derivatives) const {
  const double offset = globals.gps_time_offset;
  const Vector3d swing = measurement_.angular_rate.cross(globals.gps_lever_arm);
  const Vector3d lever = globals.gps_lever_arm + offset * swing;
  if (derivatives != nullptr) {
    const Matrix3d turned = whitening_ * x.R_map_body.matrix();
    derivatives->from.middleCols<3>(kPosition) = whitening_;
    derivatives->from.middleCols<3>(kRotation) = -turned * skew(lever);
    derivatives->from.middleCols<3>(kVelocity) = offset * whitening_;
    derivatives->globals.middleCols<3>(kGpsLeverArm) =
        turned + offset * turned * skew(measurement_.angular_rate);
    derivatives->globals.col(kGpsTimeOffset) = whitening_ * (x.velocity + x.R_map_body * swing);
  }
  return whitening_ *
         (x.position + offset * x.velocity + x.R_map_body * lever - measurement_.position);
}

}  // namespace pipescout::estimation
