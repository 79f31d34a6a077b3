// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/visual_pose_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;
using geometry::SO3;

InputFault check(const VisualPoseMeasurement& m) noexcept {
  return verdict(finite({m.time}) && finite(m.T_rack_body) && m.covariance.allFinite() &&
                     m.angular_rate.allFinite(),
                 is_covariance(m.covariance));
}

void add_values(const VisualPoseMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.T_rack_body);
}

VisualPoseFactor::VisualPoseFactor(const VisualPoseMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = whitening_of(measurement.covariance);
}

VisualPoseFactor::Residual VisualPoseFactor::evaluate(const NavState& x,
                                                      const GlobalStates& globals,
                                                      Derivatives* derivatives) const {
  const double offset = globals.visual_pose_time_offset;
  const SO3 R_rack_map = globals.R_map_rack.inverse();
  const Vector3d in_rack = R_rack_map * (x.position + offset * x.velocity - globals.rack_position);
  const SO3 turned = SO3::exp(offset * measurement_.angular_rate);
  const SO3 R_rack_body = R_rack_map * x.R_map_body * turned;
  const Vector3d angle = (measurement_.T_rack_body.rotation().inverse() * R_rack_body).log();
  Residual r;
  r << in_rack - measurement_.T_rack_body.translation(), angle;
  if (derivatives != nullptr) {
    const Matrix3d to_rack = R_rack_map.matrix();
    const Matrix3d inverse = SO3::right_jacobian_inverse(angle);
    const auto by_translation = whitening_.leftCols<3>();
    const auto by_angle = whitening_.rightCols<3>();
    derivatives->from.middleCols<3>(kPosition) = by_translation * to_rack;
    derivatives->from.middleCols<3>(kRotation) = by_angle * inverse * turned.inverse().matrix();
    derivatives->from.middleCols<3>(kVelocity) = offset * by_translation * to_rack;
    derivatives->globals.col(kVisualPoseTimeOffset) =
        by_translation * to_rack * x.velocity + by_angle * inverse * measurement_.angular_rate;
    derivatives->globals.middleCols<3>(kRackPosition) = -by_translation * to_rack;
    derivatives->globals.middleCols<3>(kRackRotation) =
        by_translation * skew(in_rack) - by_angle * inverse * R_rack_body.inverse().matrix();
  }
  return whitening_ * r;
}

}  // namespace pipescout::estimation
