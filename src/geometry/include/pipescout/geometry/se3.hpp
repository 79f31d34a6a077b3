// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pipescout/geometry/so3.hpp"

namespace pipescout::geometry {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A rigid motion. `T_a_b` maps coordinates in frame b to frame a.
///
/// Tangent vectors are [translation; rotation], m and rad, in the order of the generators G1..G6
/// of Lippiello and Cacace (equation 6) and of the covariances of ROS messages. "Left"
/// perturbations are in frame a, T' = exp(xi) T; "right" ones in frame b, T' = T exp(xi), as
/// equation (5) of the same paper.
class SE3 {
 public:
  static constexpr int kDegreesOfFreedom = 6;
  using Tangent = Vector6d;
  using TangentMatrix = Matrix6d;

  SE3() = default;  ///< identity
  /// Throws std::invalid_argument when the translation is not finite.
  SE3(const SO3& rotation, const Eigen::Vector3d& translation);
  /// Throws std::invalid_argument as SO3::from_matrix, and when the last row is not 0 0 0 1.
  [[nodiscard]] static SE3 from_matrix(const Eigen::Matrix4d& m);

  /// Exponential map, equation (7). Throws std::invalid_argument for NaN or infinity.
  [[nodiscard]] static SE3 exp(const Tangent& xi);
  /// Its inverse; the rotation vector has a norm of 0 to pi.
  [[nodiscard]] Tangent log() const noexcept;

  [[nodiscard]] SE3 inverse() const noexcept;
  [[nodiscard]] SE3 operator*(const SE3& other) const noexcept;
  /// The point `p` in the other frame.
  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& p) const noexcept;

  /// Ad with exp(Ad xi) = T exp(xi) T^-1.
  [[nodiscard]] TangentMatrix adjoint() const noexcept;

  /// As those of SO3.
  [[nodiscard]] static TangentMatrix left_jacobian(const Tangent& xi) noexcept;
  [[nodiscard]] static TangentMatrix right_jacobian(const Tangent& xi) noexcept;
  [[nodiscard]] static TangentMatrix left_jacobian_inverse(const Tangent& xi) noexcept;
  [[nodiscard]] static TangentMatrix right_jacobian_inverse(const Tangent& xi) noexcept;

  [[nodiscard]] const SO3& rotation() const noexcept { return rotation_; }
  [[nodiscard]] const Eigen::Vector3d& translation() const noexcept { return translation_; }
  [[nodiscard]] Eigen::Matrix4d matrix() const noexcept;

 private:
  SO3 rotation_;
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
};

}  // namespace pipescout::geometry
