// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/se3.hpp"

#include <stdexcept>

#include "angle_series.hpp"

namespace pipescout::geometry {
namespace {

/// Upper right block of the left Jacobian (Barfoot and Furgale 2014, "Associating uncertainty with
/// three-dimensional poses", equation 102).
Eigen::Matrix3d coupling(const Eigen::Vector3d& rho, const Eigen::Vector3d& phi) {
  const double a = phi.norm();
  const Eigen::Matrix3d r = skew(rho);
  const Eigen::Matrix3d p = skew(phi);
  const double second = angle_minus_sine_over_cube(a);
  const double third = cosine_remainder_over_fourth(a);
  // (third term's coefficient - 3 sine remainder) / 2 of that equation.
  const double fourth = 0.5 * (third + 3 * sine_remainder_over_fifth(a));
  const Eigen::Matrix3d prp = p * r * p;
  return 0.5 * r + second * (p * r + r * p + prp) + third * (p * p * r + r * p * p - 3 * prp) +
         fourth * (prp * p + p * prp);
}

}  // namespace

SE3::SE3(const SO3& rotation, const Eigen::Vector3d& translation)
    : rotation_(rotation), translation_(translation) {
  if (!translation.allFinite()) {
    throw std::invalid_argument("SE3: the translation is not finite");
  }
}

SE3 SE3::from_matrix(const Eigen::Matrix4d& m) {
  if (!(m.row(3).transpose() - Eigen::Vector4d::UnitW()).isZero(1e-9)) {
    throw std::invalid_argument("SE3::from_matrix: the last row is not 0 0 0 1");
  }
  return {SO3::from_matrix(m.topLeftCorner<3, 3>()), m.topRightCorner<3, 1>()};
}

SE3 SE3::exp(const Tangent& xi) {
  if (!xi.allFinite()) {
    throw std::invalid_argument("SE3::exp: the tangent vector is not finite");
  }
  return {SO3::exp(xi.tail<3>()), SO3::left_jacobian(xi.tail<3>()) * xi.head<3>()};
}

SE3::Tangent SE3::log() const noexcept {
  const Eigen::Vector3d phi = rotation_.log();
  Tangent xi;
  xi << SO3::left_jacobian_inverse(phi) * translation_, phi;
  return xi;
}

SE3 SE3::inverse() const noexcept {
  SE3 result;
  result.rotation_ = rotation_.inverse();
  result.translation_ = -(result.rotation_ * translation_);
  return result;
}

SE3 SE3::operator*(const SE3& other) const noexcept {
  SE3 result;
  result.rotation_ = rotation_ * other.rotation_;
  result.translation_ = rotation_ * other.translation_ + translation_;
  return result;
}

Eigen::Vector3d SE3::operator*(const Eigen::Vector3d& p) const noexcept {
  return rotation_ * p + translation_;
}

SE3::TangentMatrix SE3::adjoint() const noexcept {
  const Eigen::Matrix3d r = rotation_.matrix();
  TangentMatrix ad;
  ad << r, skew(translation_) * r, Eigen::Matrix3d::Zero(), r;
  return ad;
}

SE3::TangentMatrix SE3::left_jacobian(const Tangent& xi) noexcept {
  const Eigen::Matrix3d j = SO3::left_jacobian(xi.tail<3>());
  TangentMatrix result;
  result << j, coupling(xi.head<3>(), xi.tail<3>()), Eigen::Matrix3d::Zero(), j;
  return result;
}

SE3::TangentMatrix SE3::right_jacobian(const Tangent& xi) noexcept {
  return left_jacobian(-xi);
}

SE3::TangentMatrix SE3::left_jacobian_inverse(const Tangent& xi) noexcept {
  const Eigen::Matrix3d j = SO3::left_jacobian_inverse(xi.tail<3>());
  TangentMatrix result;
  result << j, -j * coupling(xi.head<3>(), xi.tail<3>()) * j, Eigen::Matrix3d::Zero(), j;
  return result;
}

SE3::TangentMatrix SE3::right_jacobian_inverse(const Tangent& xi) noexcept {
  return left_jacobian_inverse(-xi);
}

Eigen::Matrix4d SE3::matrix() const noexcept {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation_.matrix();
  m.topRightCorner<3, 1>() = translation_;
  return m;
}

}  // namespace pipescout::geometry
