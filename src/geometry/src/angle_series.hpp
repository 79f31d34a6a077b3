// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

/// The functions of an angle a >= 0 (rad) from which exponential maps and their Jacobians are made.
/// Their closed forms lose digits as a falls, that of `sine_remainder_over_fifth` ten of them at
/// 0.1 already; below kSmallAngle each is its Taylor series, cut where the next term is below
/// rounding there. Relative errors stay below 1e-13 up to pi (tested against long double).
namespace pipescout::geometry {

inline constexpr double kSmallAngle = 1;

/// 1/first! - q/(first+2)! + q^2/(first+4)! - ...: the common form of all series here.
template <std::size_t kFirst>
double alternating_series(double q) noexcept {
  constexpr std::size_t kTerms = 10;  // 1/20! is below 1e-18
  double sum = 1;
  for (std::size_t i = kTerms - 1; i > 0; --i) {
    const auto n = static_cast<double>(kFirst + 2 * i);
    sum = 1 - q / (n * (n - 1)) * sum;
  }
  double factorial = 1;
  for (std::size_t n = 2; n <= kFirst; ++n) {
    factorial *= static_cast<double>(n);
  }
  return sum / factorial;
}

/// sin(a / 2) / a
inline double half_sine_over_angle(double a) noexcept {
  return a < kSmallAngle ? 0.5 * alternating_series<1>(0.25 * a * a) : std::sin(0.5 * a) / a;
}

/// (1 - cos a) / a^2, as 2 sin^2(a / 2) / a^2: without a difference
inline double one_minus_cosine_over_square(double a) noexcept {
  const double half = half_sine_over_angle(a);
  return 2 * half * half;
}

/// (a - sin a) / a^3
inline double angle_minus_sine_over_cube(double a) noexcept {
  const double q = a * a;
  return a < kSmallAngle ? alternating_series<3>(q) : (a - std::sin(a)) / (q * a);
}

/// (a^2 / 2 + cos a - 1) / a^4
inline double cosine_remainder_over_fourth(double a) noexcept {
  const double q = a * a;
  return a < kSmallAngle ? alternating_series<4>(q) : (0.5 * q + std::cos(a) - 1) / (q * q);
}

/// (a - sin a - a^3 / 6) / a^5
inline double sine_remainder_over_fifth(double a) noexcept {
  const double q = a * a;
  return a < kSmallAngle ? -alternating_series<5>(q) : (a - std::sin(a) - q * a / 6) / (q * q * a);
}

/// 1 / a^2 - (1 + cos a) / (2 a sin a), from functions that are finite at 0 and at pi.
inline double inverse_jacobian_coefficient(double a) noexcept {
  return (angle_minus_sine_over_cube(a) - 2 * cosine_remainder_over_fourth(a)) /
         (2 * one_minus_cosine_over_square(a));
}

}  // namespace pipescout::geometry
