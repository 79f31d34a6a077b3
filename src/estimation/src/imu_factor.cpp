// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>

#include "pipescout/estimation/imu_preintegration.hpp"
#include "pipescout/linear_algebra/cholesky.hpp"
#include "pipescout/linear_algebra/products.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;
using geometry::SO3;

ImuFactor::ImuFactor(const ImuPreintegration& preintegration, const Gravity& gravity)
    : motion_(preintegration.motion()), gravity_(gravity) {
  const linear_algebra::Cholesky<kStateSize> root(preintegration.covariance());
  if (!root.succeeded() || !preintegration.covariance().allFinite()) {
    throw std::invalid_argument("ImuFactor: the covariance is not positive definite");
  }
  square_root_information_ = root.inverse_lower();
}

ImuFactor::Residual ImuFactor::evaluate(const NavState& from, const NavState& to,
                                        const GlobalStates& globals,
                                        Jacobians<kRows>* jacobians) const {
  const Eigen::Matrix<double, 9, 1> correction = motion_.correction(from, globals.imu_scale);
  const Vector3d turn = correction.segment<3>(3);
  const double duration = motion_.duration();
  const Vector3d fall = duration * gravity_.acceleration(from.position, from.velocity);
  const Matrix3d to_body = from.R_map_body.matrix().transpose();
  const Vector3d moved =
      to_body * (to.position - from.position - duration * (from.velocity + 0.5 * fall));
  const Vector3d gained = to_body * (to.velocity - from.velocity - fall);
  const SO3 between = from.R_map_body.inverse() * to.R_map_body;
  const Vector3d angle = ((motion_.rotation() * SO3::exp(turn)).inverse() * between).log();

  Residual r;
  r.segment<3>(kPosition) = moved - motion_.position() - correction.head<3>();
  r.segment<3>(kRotation) = angle;
  r.segment<3>(kVelocity) = gained - motion_.velocity() - correction.tail<3>();
  r.segment<3>(kGyroBias) = to.gyro_bias - from.gyro_bias;
  r.segment<3>(kAccelerometerBias) = to.accelerometer_bias - from.accelerometer_bias;
  if (jacobians != nullptr) {
    auto& i = jacobians->from;
    auto& j = jacobians->to;
    const Matrix3d inverse = SO3::right_jacobian_inverse(angle);
    i.setZero();
    j.setZero();
    i.block<3, 3>(kPosition, kPosition) = -to_body;
    i.block<3, 3>(kPosition, kRotation) = skew(moved);
    i.block<3, 3>(kPosition, kVelocity) = -duration * to_body;
    i.block<3, 6>(kPosition, kGyroBias) = -motion_.bias_jacobian().topRows<3>();
    j.block<3, 3>(kPosition, kPosition) = to_body;
    i.block<3, 3>(kRotation, kRotation) = -inverse * between.matrix().transpose();
    const Matrix3d by_turn =
        -inverse * SO3::exp(angle).matrix().transpose() * SO3::right_jacobian(turn);
    i.block<3, 6>(kRotation, kGyroBias) = by_turn * motion_.bias_jacobian().middleRows<3>(3);
    j.block<3, 3>(kRotation, kRotation) = inverse;
    i.block<3, 3>(kVelocity, kRotation) = skew(gained);
    i.block<3, 3>(kVelocity, kVelocity) = -to_body;
    i.block<3, 6>(kVelocity, kGyroBias) = -motion_.bias_jacobian().bottomRows<3>();
    j.block<3, 3>(kVelocity, kVelocity) = to_body;
    i.block<6, 6>(kGyroBias, kGyroBias).diagonal().setConstant(-1);
    j.block<6, 6>(kGyroBias, kGyroBias).diagonal().setConstant(1);
    i = linear_algebra::product<kStateSize>(square_root_information_, i);
    j = linear_algebra::product<kStateSize>(square_root_information_, j);
    if (motion_.scaled()) {
      ImuMotion::ScaleJacobian by_scale = -motion_.scale_jacobian();
      by_scale.middleRows<3>(3) = by_turn * motion_.scale_jacobian().middleRows<3>(3);
      jacobians->globals.middleCols<kImuScaleSize>(kImuScale) =
          square_root_information_.leftCols<9>() * by_scale;
    }
  }
  return square_root_information_ * r;
}

}  // namespace pipescout::estimation
