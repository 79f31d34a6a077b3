// SPDX-License-Identifier: Apache-2.0
#include "rigid_transform.hpp"

#include <algorithm>

namespace pipescout::rigid {
namespace {

struct Weights {
  double a = 0;
  double b = 0;
};

/// sin(part angle) / sin(angle) by the series of D. Eberly, "A fast and accurate algorithm for
/// computing SLERP", Journal of Graphics, GPU and Game Tools 15(3), 2011, which needs neither a
/// root, nor a division, nor a trigonometric function. `chord` = 2 (1 - cos angle). Each term is
/// below chord / 4 of the one before.
template <int kTerms>
double sine_ratio(double chord, double part) noexcept {
  const double x = -chord / 2;
  const double square = part * part;
  double sum = 1;
  for (int i = kTerms; i > 0; --i) {
    const double step = 2 * i + 1;
    sum = 1 + sum * x * (square * (1 / (i * step)) - i / step);
  }
  return part * sum;
}

/// Of spherical interpolation between unit quaternions whose difference has the squared norm
/// `chord` (at most 2: they are on the same side).
Weights slerp_weights(double chord, double part) noexcept {
  // Both bounds leave less than 1e-16. The first is 7 degrees of rotation, more than what turns at
  // 100 Hz does between two samples; the second is 28 degrees.
  if (chord < 0.004) {
    return {sine_ratio<5>(chord, 1 - part), sine_ratio<5>(chord, part)};
  }
  if (chord < 0.0625) {
    return {sine_ratio<9>(chord, 1 - part), sine_ratio<9>(chord, part)};
  }
  const double angle = 2 * std::asin(std::min(std::sqrt(chord) / 2, 1.0));
  const double whole = std::sin(angle);
  return {std::sin((1 - part) * angle) / whole, std::sin(part * angle) / whole};
}

}  // namespace

RigidTransform interpolate(const RigidTransform& a, const RigidTransform& b, double part) noexcept {
  RigidTransform result;
  for (std::size_t i = 0; i < 3; ++i) {
    result.translation[i] = a.translation[i] + part * (b.translation[i] - a.translation[i]);
  }
  double dot = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    dot += a.rotation[i] * b.rotation[i];
  }
  const double sign = dot < 0 ? -1 : 1;  // q and -q are the same rotation: the nearer one
  double chord = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double difference = sign * b.rotation[i] - a.rotation[i];
    chord += difference * difference;
  }
  const Weights weights = slerp_weights(chord, part);
  for (std::size_t i = 0; i < 4; ++i) {
    result.rotation[i] = weights.a * a.rotation[i] + weights.b * sign * b.rotation[i];
  }
  return result;
}

RigidTransform from_message(const geometry_msgs::msg::Transform& message) noexcept {
  return {{message.translation.x, message.translation.y, message.translation.z},
          {message.rotation.x, message.rotation.y, message.rotation.z, message.rotation.w}};
}

geometry_msgs::msg::Transform to_message(const RigidTransform& transform) noexcept {
  geometry_msgs::msg::Transform message;
  message.translation.x = transform.translation[0];
  message.translation.y = transform.translation[1];
  message.translation.z = transform.translation[2];
  message.rotation.x = transform.rotation[0];
  message.rotation.y = transform.rotation[1];
  message.rotation.z = transform.rotation[2];
  message.rotation.w = transform.rotation[3];
  return message;
}

}  // namespace pipescout::rigid
