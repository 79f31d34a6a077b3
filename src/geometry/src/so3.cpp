// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/so3.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "angle_series.hpp"

namespace pipescout::geometry {
namespace {

constexpr double kNotARotation = 1e-6;

/// To [-pi, pi].
double wrapped(double angle) {
  return std::remainder(angle, 2 * std::numbers::pi);
}

/// Products of unit quaternions drift from unit norm by rounding; w >= 0 makes log() short.
Eigen::Quaterniond normalised(const Eigen::Quaterniond& q) {
  const double scale = (q.w() < 0 ? -1.0 : 1.0) / q.norm();
  return {scale * q.w(), scale * q.x(), scale * q.y(), scale * q.z()};
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) noexcept {
  return (Eigen::Matrix3d() << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0).finished();
}

Eigen::Vector3d unskew(const Eigen::Matrix3d& m) noexcept {
  return 0.5 * Eigen::Vector3d(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
}

SO3 SO3::from_matrix(const Eigen::Matrix3d& m) {
  const double error = (m.transpose() * m - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  // Written so that NaN fails too.
  if (!(m.allFinite() && error <= kNotARotation && m.determinant() > 0)) {
    throw std::invalid_argument("SO3::from_matrix: the matrix is not a rotation");
  }
  // Newton's iteration for the nearest rotation; the quaternion of a matrix that is not quite one
  // would depend on which of its entries is off. The error is squared each time: 1e-12, 1e-24.
  Eigen::Matrix3d nearest = m;
  for (int i = 0; i < 2; ++i) {
    nearest = (1.5 * nearest - 0.5 * nearest * nearest.transpose() * nearest).eval();
  }
  return SO3(normalised(Eigen::Quaterniond(nearest)));
}

SO3 SO3::from_quaternion(const Eigen::Quaterniond& q) {
  if (!(std::abs(q.norm() - 1) <= kNotARotation)) {
    throw std::invalid_argument("SO3::from_quaternion: the quaternion's norm is not 1");
  }
  return SO3(normalised(q));
}

SO3 SO3::about_x(double angle) {
  return exp({angle, 0, 0});
}
SO3 SO3::about_y(double angle) {
  return exp({0, angle, 0});
}
SO3 SO3::about_z(double angle) {
  return exp({0, 0, angle});
}

SO3 SO3::from_roll_pitch_yaw(const Eigen::Vector3d& roll_pitch_yaw) {
  return about_z(roll_pitch_yaw.z()) * about_y(roll_pitch_yaw.y()) * about_x(roll_pitch_yaw.x());
}

SO3 SO3::exp(const Tangent& phi) {
  const double angle = phi.norm();
  if (!std::isfinite(angle)) {
    throw std::invalid_argument("SO3::exp: the rotation vector or its norm is not finite");
  }
  const double half_sinc = half_sine_over_angle(angle);
  return SO3(normalised(Eigen::Quaterniond(std::cos(0.5 * angle), half_sinc * phi.x(),
                                           half_sinc * phi.y(), half_sinc * phi.z())));
}

SO3::Tangent SO3::log() const noexcept {
  const double sine = quaternion_.vec().norm();
  // w >= 0, so that the angle is at most pi; atan2 is exact near pi and near 0.
  const double half_angle = std::atan2(sine, quaternion_.w());
  const double factor = sine < 1e-12 ? 2 / quaternion_.w() : 2 * half_angle / sine;
  return factor * quaternion_.vec();
}

SO3 SO3::inverse() const noexcept {
  return SO3(quaternion_.conjugate());
}

SO3 SO3::operator*(const SO3& other) const noexcept {
  return SO3(normalised(quaternion_ * other.quaternion_));
}

Eigen::Vector3d SO3::operator*(const Eigen::Vector3d& v) const noexcept {
  const Eigen::Vector3d twice = 2 * quaternion_.vec().cross(v);
  return v + quaternion_.w() * twice + quaternion_.vec().cross(twice);
}

SO3::TangentMatrix SO3::left_jacobian(const Tangent& phi) noexcept {
  const double angle = phi.norm();
  const Eigen::Matrix3d s = skew(phi);
  return Eigen::Matrix3d::Identity() + one_minus_cosine_over_square(angle) * s +
         angle_minus_sine_over_cube(angle) * s * s;
}

SO3::TangentMatrix SO3::right_jacobian(const Tangent& phi) noexcept {
  return left_jacobian(-phi);
}

SO3::TangentMatrix SO3::left_jacobian_inverse(const Tangent& phi) noexcept {
  const Eigen::Matrix3d s = skew(phi);
  return Eigen::Matrix3d::Identity() - 0.5 * s + inverse_jacobian_coefficient(phi.norm()) * s * s;
}

SO3::TangentMatrix SO3::right_jacobian_inverse(const Tangent& phi) noexcept {
  return left_jacobian_inverse(-phi);
}

Eigen::Vector3d SO3::roll_pitch_yaw() const noexcept {
  // From the half angles' sum and difference, w - y = (c - s) cos((roll + yaw) / 2) and so on with
  // c, s of half the pitch: unlike the entries of the matrix, exact next to gimbal lock.
  constexpr double kLock = 1e-14;
  const Eigen::Quaterniond& q = quaternion_;
  const double minus = std::hypot(q.x() + q.z(), q.w() - q.y());
  const double plus = std::hypot(q.x() - q.z(), q.w() + q.y());
  const double half_sum = std::atan2(q.x() + q.z(), q.w() - q.y());
  const double half_difference = std::atan2(q.x() - q.z(), q.w() + q.y());
  const double pitch = 2 * std::atan2(plus - minus, plus + minus);
  if (minus < kLock) {
    return {0, pitch, wrapped(-2 * half_difference)};
  }
  if (plus < kLock) {
    return {0, pitch, wrapped(2 * half_sum)};
  }
  return {wrapped(half_sum + half_difference), pitch, wrapped(half_sum - half_difference)};
}

}  // namespace pipescout::geometry
