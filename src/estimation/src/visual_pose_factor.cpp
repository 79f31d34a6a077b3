// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/visual_pose_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;
using geometry::SO3;

InputFault check(const VisualPoseMeasurement& m) noexcept {
  return verdict(finite({m.time}) && finite(m.T_rack_body) && m.covariance.allFinite(),
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
  const SO3 R_rack_map = globals.R_map_rack.inverse();
  const Vector3d in_rack = R_rack_map * (x.position - globals.rack_position);
  const SO3 R_rack_body = R_rack_map * x.R_map_body;
  const Vector3d angle = (measurement_.T_rack_body.rotation().inverse() * R_rack_body).log();
  Residual r;
  r << in_rack - measurement_.T_rack_body.translation(), angle;
  if (derivatives != nullptr) {
    const Matrix3d to_rack = R_rack_map.matrix();
    const Matrix3d inverse = SO3::right_jacobian_inverse(angle);
    const auto by_translation = whitening_.leftCols<3>();
    const auto by_angle = whitening_.rightCols<3>();
    derivatives->from.middleCols<3>(kPosition) = by_translation * to_rack;
    derivatives->from.middleCols<3>(kRotation) = by_angle * inverse;
    derivatives->globals.middleCols<3>(kRackPosition) = -by_translation * to_rack;
    derivatives->globals.middleCols<3>(kRackRotation) =
        by_translation * skew(in_rack) - by_angle * inverse * R_rack_body.inverse().matrix();
  }
  return whitening_ * r;
}

}  // namespace pipescout::estimation
