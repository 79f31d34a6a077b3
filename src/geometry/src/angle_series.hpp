// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

/// The functions of an angle (rad, any sign is >= 0 here) from which exponential maps and their
/// Jacobians are made. Their closed forms lose all digits near zero; below kSmallAngle each is its
/// Taylor series, cut where the next term is below rounding there.
namespace pipescout::geometry {

inline constexpr double kSmallAngle = 0.1;

/// sin(a / 2) / a
inline double half_sine_over_angle(double a) noexcept {
  const double q = a * a;
  if (a < kSmallAngle) {
    return 0.5 * (1 - q / 24 * (1 - q / 80 * (1 - q / 168 * (1 - q / 288))));
  }
  return std::sin(0.5 * a) / a;
}

/// (1 - cos a) / a^2
inline double one_minus_cosine_over_square(double a) noexcept {
  const double q = a * a;
  if (a < kSmallAngle) {
    return 0.5 * (1 - q / 12 * (1 - q / 30 * (1 - q / 56 * (1 - q / 90 * (1 - q / 132)))));
  }
  return (1 - std::cos(a)) / q;
}

/// (a - sin a) / a^3
inline double angle_minus_sine_over_cube(double a) noexcept {
  const double q = a * a;
  if (a < kSmallAngle) {
    return (1 - q / 20 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110 * (1 - q / 156))))) / 6;
  }
  return (a - std::sin(a)) / (q * a);
}

/// (a^2 / 2 + cos a - 1) / a^4
inline double cosine_remainder_over_fourth(double a) noexcept {
  const double q = a * a;
  if (a < kSmallAngle) {
    return (1 - q / 30 * (1 - q / 56 * (1 - q / 90 * (1 - q / 132)))) / 24;
  }
  return (0.5 * q + std::cos(a) - 1) / (q * q);
}

/// (a - sin a - a^3 / 6) / a^5
inline double sine_remainder_over_fifth(double a) noexcept {
  const double q = a * a;
  if (a < kSmallAngle) {
    return -(1 - q / 42 * (1 - q / 72 * (1 - q / 110 * (1 - q / 156)))) / 120;
  }
  return (a - std::sin(a) - q * a / 6) / (q * q * a);
}

/// 1 / a^2 - (1 + cos a) / (2 a sin a), written so that it is right at pi too.
inline double inverse_jacobian_coefficient(double a) noexcept {
  const double q = a * a;
  if (a < kSmallAngle) {
    return 1.0 / 12 + q * (1.0 / 720 + q * (1.0 / 30240 + q * (1.0 / 1209600 + q / 47900160)));
  }
  return (1 - 0.5 * a / std::tan(0.5 * a)) / q;
}

}  // namespace pipescout::geometry
