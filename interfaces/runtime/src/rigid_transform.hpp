// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <geometry_msgs/msg/transform.hpp>

/// Of its own, as `interfaces/catalogue` has functions of the same names for its own types.
namespace pipescout::rigid {

/// A rotation (unit quaternion x y z w), then a translation. The runtime needs no more of geometry
/// than this, and links no library of it.
struct RigidTransform {
  std::array<double, 3> translation{};
  std::array<double, 4> rotation{0, 0, 0, 1};
};

/// `v` turned by the unit quaternion `q`: v + 2 w (u x v) + 2 u x (u x v), u the vector part.
[[nodiscard]] inline std::array<double, 3> rotate(const std::array<double, 4>& q,
                                                  const std::array<double, 3>& v) noexcept {
  const double a = 2 * (q[1] * v[2] - q[2] * v[1]);
  const double b = 2 * (q[2] * v[0] - q[0] * v[2]);
  const double c = 2 * (q[0] * v[1] - q[1] * v[0]);
  return {v[0] + q[3] * a + q[1] * c - q[2] * b, v[1] + q[3] * b + q[2] * a - q[0] * c,
          v[2] + q[3] * c + q[0] * b - q[1] * a};
}

[[nodiscard]] inline std::array<double, 4> multiply(const std::array<double, 4>& a,
                                                    const std::array<double, 4>& b) noexcept {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
          a[3] * b[1] + a[1] * b[3] + a[2] * b[0] - a[0] * b[2],
          a[3] * b[2] + a[2] * b[3] + a[0] * b[1] - a[1] * b[0],
          a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

/// First `b`, then `a`.
[[nodiscard]] inline RigidTransform operator*(const RigidTransform& a,
                                              const RigidTransform& b) noexcept {
  RigidTransform result;
  result.translation = rotate(a.rotation, b.translation);
  for (std::size_t i = 0; i < 3; ++i) {
    result.translation[i] += a.translation[i];
  }
  result.rotation = multiply(a.rotation, b.rotation);
  return result;
}

[[nodiscard]] inline RigidTransform inverse(const RigidTransform& a) noexcept {
  RigidTransform result;
  result.rotation = {-a.rotation[0], -a.rotation[1], -a.rotation[2], a.rotation[3]};
  result.translation = rotate(result.rotation, a.translation);
  for (double& value : result.translation) {
    value = -value;
  }
  return result;
}

/// `part` in [0, 1] of the way from `a` to `b`: the position on a line, the rotation on the
/// shortest arc at constant rate (Shoemake 1985, "Animating rotation with quaternion curves").
[[nodiscard]] RigidTransform interpolate(const RigidTransform& a, const RigidTransform& b,
                                         double part) noexcept;

[[nodiscard]] RigidTransform from_message(const geometry_msgs::msg::Transform& message) noexcept;
[[nodiscard]] geometry_msgs::msg::Transform to_message(const RigidTransform& transform) noexcept;

}  // namespace pipescout::rigid
