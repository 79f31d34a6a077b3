// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/relative_pose_factor.hpp"

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;
using geometry::SO3;

InputFault check(const RelativePoseMeasurement& m) noexcept {
  const InputFault fault =
      verdict(finite({m.from_time, m.to_time}) && finite(m.T_from_to) && m.covariance.allFinite(),
              is_covariance(m.covariance));
  return fault == InputFault::kNone && m.to_time <= m.from_time ? InputFault::kBadInterval : fault;
}

void add_values(const RelativePoseMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.T_from_to);
}

RelativePoseFactor::RelativePoseFactor(const RelativePoseMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = whitening_of(measurement.covariance);
}

RelativePoseFactor::Residual RelativePoseFactor::evaluate(const NavState& from, const NavState& to,
                                                          const GlobalStates& /*globals*/,
                                                          Derivatives* derivatives) const {
  const SO3 R_to_from = measurement_.T_from_to.rotation().inverse();
  const Vector3d seen = from.R_map_body.inverse() * (to.position - from.position);
  const SO3 between = from.R_map_body.inverse() * to.R_map_body;
  const Vector3d angle = (R_to_from * between).log();
  Residual r;
  r << R_to_from * (seen - measurement_.T_from_to.translation()), angle;
  if (derivatives != nullptr) {
    const Matrix3d inverse = SO3::right_jacobian_inverse(angle);
    const Eigen::Matrix<double, 6, 3> by_translation =
        whitening_.leftCols<3>() * R_to_from.matrix();
    const Eigen::Matrix<double, 6, 3> by_angle = whitening_.rightCols<3>() * inverse;
    const Eigen::Matrix<double, 6, 3> by_position =
        by_translation * from.R_map_body.matrix().transpose();
    derivatives->from.middleCols<3>(kPosition) = -by_position;
    derivatives->to.middleCols<3>(kPosition) = by_position;
    derivatives->from.middleCols<3>(kRotation) =
        by_translation * skew(seen) - by_angle * between.matrix().transpose();
    derivatives->to.middleCols<3>(kRotation) = by_angle;
  }
  return whitening_ * r;
}

}  // namespace pipescout::estimation
