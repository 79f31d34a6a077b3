// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace pipescout::geometry {

/// Skew-symmetric matrix S(v) with S(v) w = v x w.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v) noexcept;

/// Inverse of `skew`: reads the upper and the lower triangle and takes their mean.
[[nodiscard]] Eigen::Vector3d unskew(const Eigen::Matrix3d& m) noexcept;

/// A rotation. `R_a_b` maps coordinates in frame b to frame a.
///
/// Tangent vectors are rotation vectors, rad. Perturbations named "left" act in frame a, R' =
/// exp(phi) R; those named "right" act in frame b, R' = R exp(phi). A value is always a rotation:
/// products are normalised, so that a chain of millions of them remains a rotation (tested). All
/// functions are pure and allocate nothing unless they throw.
class SO3 {
 public:
  static constexpr int kDegreesOfFreedom = 3;
  using Tangent = Eigen::Vector3d;
  using TangentMatrix = Eigen::Matrix3d;

  SO3() = default;  ///< identity
  /// Throws std::invalid_argument when `m` contains NaN or differs from a rotation by more than
  /// 1e-6 in any entry of M^T M - I, or is a reflection. Otherwise the rotation nearest to it.
  [[nodiscard]] static SO3 from_matrix(const Eigen::Matrix3d& m);
  /// Throws std::invalid_argument when the norm of `q` differs from 1 by more than 1e-6 or is NaN.
  [[nodiscard]] static SO3 from_quaternion(const Eigen::Quaterniond& q);
  /// Rotations about the axes x, y, z, rad.
  [[nodiscard]] static SO3 about_x(double angle);
  [[nodiscard]] static SO3 about_y(double angle);
  [[nodiscard]] static SO3 about_z(double angle);
  /// Rz(yaw) Ry(pitch) Rx(roll), rad, as REP 103.
  [[nodiscard]] static SO3 from_roll_pitch_yaw(const Eigen::Vector3d& roll_pitch_yaw);

  /// Exponential map. Throws std::invalid_argument when the norm of `phi` is NaN or infinite (from
  /// 1e154 on it overflows).
  [[nodiscard]] static SO3 exp(const Tangent& phi);
  /// Rotation vector of norm 0 to pi; at pi one of the two solutions.
  [[nodiscard]] Tangent log() const noexcept;

  [[nodiscard]] SO3 inverse() const noexcept;
  [[nodiscard]] SO3 operator*(const SO3& other) const noexcept;
  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& v) const noexcept;

  /// Ad with exp(Ad phi) = R exp(phi) R^-1.
  [[nodiscard]] TangentMatrix adjoint() const noexcept { return matrix(); }

  /// exp(phi + d) = exp(left_jacobian(phi) d) exp(phi) to first order in d.
  [[nodiscard]] static TangentMatrix left_jacobian(const Tangent& phi) noexcept;
  /// exp(phi + d) = exp(phi) exp(right_jacobian(phi) d) to first order in d.
  [[nodiscard]] static TangentMatrix right_jacobian(const Tangent& phi) noexcept;
  /// Their inverses; they exist for norms of phi below 2 pi.
  [[nodiscard]] static TangentMatrix left_jacobian_inverse(const Tangent& phi) noexcept;
  [[nodiscard]] static TangentMatrix right_jacobian_inverse(const Tangent& phi) noexcept;

  [[nodiscard]] Eigen::Matrix3d matrix() const noexcept { return quaternion_.toRotationMatrix(); }
  /// Unit quaternion with w >= 0.
  [[nodiscard]] const Eigen::Quaterniond& quaternion() const noexcept { return quaternion_; }
  /// Angles of `from_roll_pitch_yaw`, rad: pitch in [-pi/2, pi/2], the others in [-pi, pi]. At
  /// pitch
  /// +-pi/2 only their difference or sum is defined, and roll is 0.
  [[nodiscard]] Eigen::Vector3d roll_pitch_yaw() const noexcept;

 private:
  explicit SO3(const Eigen::Quaterniond& unit) noexcept : quaternion_(unit) {}
  Eigen::Quaterniond quaternion_ = Eigen::Quaterniond::Identity();
};

}  // namespace pipescout::geometry
