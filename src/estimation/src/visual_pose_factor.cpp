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
                     m.angular_rate.allFinite() && m.camera.allFinite() &&
                     m.mounting <= kOwnSize - kMountingSize,
                 is_covariance(m.covariance));
}

void add_values(const VisualPoseMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.T_rack_body);
}

VisualPoseFactor::VisualPoseFactor(const VisualPoseMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = whitening_of(measurement.covariance);
}

geometry::SE3 mounting_error(const VisualPoseMeasurement& m, const GlobalStates& globals) {
  if (m.mounting < 0) {
    return {};
  }
  const SO3 turn = SO3::exp(globals.own.segment<3>(m.mounting + 3));
  return {turn, m.camera + globals.own.segment<3>(m.mounting) - turn * m.camera};
}

VisualPoseFactor::Residual VisualPoseFactor::evaluate(const NavState& x,
                                                      const GlobalStates& globals,
                                                      Derivatives* derivatives) const {
  const double offset = globals.visual_pose_time_offset;
  const SO3 R_rack_map = globals.R_map_rack.inverse();
  const SO3 turned = SO3::exp(offset * measurement_.angular_rate);
  const SO3 R_rack_body = R_rack_map * x.R_map_body * turned;
  Vector3d in_rack = R_rack_map * (x.position + offset * x.velocity - globals.rack_position);
  SO3 R_rack_seen = R_rack_body;
  geometry::SE3 error;
  const bool mounted = measurement_.mounting >= 0;
  if (mounted) {
    error = mounting_error(measurement_, globals);
    in_rack += R_rack_body * error.translation();
    R_rack_seen = R_rack_body * error.rotation();
  }
  const Vector3d angle = (measurement_.T_rack_body.rotation().inverse() * R_rack_seen).log();
  Residual r;
  r << in_rack - measurement_.T_rack_body.translation(), angle;
  if (derivatives != nullptr) {
    const Matrix3d to_rack = R_rack_map.matrix();
    const Matrix3d inverse = SO3::right_jacobian_inverse(angle);
    const auto by_translation = whitening_.leftCols<3>();
    const auto by_angle = whitening_.rightCols<3>();
    derivatives->from.middleCols<3>(kPosition) = by_translation * to_rack;
    derivatives->from.middleCols<3>(kVelocity) = offset * by_translation * to_rack;
    derivatives->globals.middleCols<3>(kRackPosition) = -by_translation * to_rack;
    derivatives->globals.middleCols<3>(kRackRotation) =
        by_translation * skew(in_rack) - by_angle * inverse * R_rack_seen.inverse().matrix();
    // By a rotation of the body, to the right of R_rack_body.
    Eigen::Matrix<double, kRows, 3> by_turn = by_angle * inverse;
    if (mounted) {
      const Vector3d turn = globals.own.segment<3>(measurement_.mounting + 3);
      const Matrix3d body = R_rack_body.matrix();
      const Matrix3d seen = R_rack_seen.matrix();
      auto by_mounting =
          derivatives->globals.middleCols<kMountingSize>(kOwnStates + measurement_.mounting);
      by_mounting.leftCols<3>() = by_translation * body;
      by_mounting.rightCols<3>() =
          (by_translation * seen * skew(measurement_.camera) + by_turn) * SO3::right_jacobian(turn);
      by_turn = (by_turn * error.rotation().inverse().matrix() -
                 by_translation * body * skew(error.translation()))
                    .eval();
    }
    derivatives->from.middleCols<3>(kRotation) = by_turn * turned.inverse().matrix();
    derivatives->globals.col(kVisualPoseTimeOffset) =
        by_translation * to_rack * x.velocity + by_turn * measurement_.angular_rate;
  }
  return whitening_ * r;
}

}  // namespace pipescout::estimation
