// SPDX-License-Identifier: Apache-2.0
#include "angle_series.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

namespace pipescout::geometry {
namespace {

/// sum of (-1)^i a^(2 i) / (first + 2 i)!, in long double. Up to 2 pi its largest term is below
/// 100, which leaves 17 digits.
long double reference_series(int first, long double a) {
  long double term = 1;
  for (int n = 2; n <= first; ++n) {
    term /= n;
  }
  long double sum = 0;
  for (int n = first; n < first + 80; n += 2) {
    sum += term;
    term *= -a * a / (static_cast<long double>(n + 1) * (n + 2));
  }
  return sum;
}

std::vector<double> angles() {
  std::vector<double> result{0, 5e-324, 1e-200, 1e-12, 1e-8, 1e-5, 1e-3, 0.1};
  result.push_back(std::nextafter(kSmallAngle, 0));
  result.push_back(kSmallAngle);
  result.push_back(std::nextafter(kSmallAngle, 2));
  result.push_back(std::numbers::pi - 1e-9);
  result.push_back(std::numbers::pi);
  for (double a = 0.05; a < 6.2; a += 0.0625) {
    result.push_back(a);
  }
  return result;
}

void expect_close(double value, long double reference, double relative, const char* name,
                  double angle) {
  EXPECT_NEAR(value, static_cast<double>(reference),
              relative * std::abs(static_cast<double>(reference)))
      << name << " at " << angle;
}

TEST(AngleSeries, AgreesWithLongDoubleOnBothSidesOfTheThreshold) {
  constexpr double kRelative = 1e-13;
  for (const double a : angles()) {
    const long double x = a;
    expect_close(half_sine_over_angle(a), reference_series(1, x / 2) / 2, kRelative, "half sine",
                 a);
    expect_close(one_minus_cosine_over_square(a), reference_series(2, x), 10 * kRelative,
                 "one minus cosine", a);
    expect_close(angle_minus_sine_over_cube(a), reference_series(3, x), kRelative,
                 "angle minus sine", a);
    expect_close(cosine_remainder_over_fourth(a), reference_series(4, x), kRelative,
                 "cosine remainder", a);
    expect_close(sine_remainder_over_fifth(a), -reference_series(5, x), kRelative, "sine remainder",
                 a);
  }
}

TEST(AngleSeries, InverseJacobianCoefficientAgreesWithLongDouble) {
  for (const double a : angles()) {
    const long double x = a;
    const long double reference =
        (reference_series(3, x) - 2 * reference_series(4, x)) / (2 * reference_series(2, x));
    expect_close(inverse_jacobian_coefficient(a), reference, a < 3.2 ? 1e-13 : 1e-10, "inverse", a);
  }
  EXPECT_DOUBLE_EQ(inverse_jacobian_coefficient(0), 1.0 / 12);
  const double pi = std::numbers::pi;
  EXPECT_NEAR(inverse_jacobian_coefficient(pi), 1 / (pi * pi), 1e-15);
}

}  // namespace
}  // namespace pipescout::geometry
