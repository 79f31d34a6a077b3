// SPDX-License-Identifier: Apache-2.0
#include "pipescout/statistics/chi_square.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "pipescout/statistics/normal.hpp"

namespace pipescout::statistics {
namespace {

TEST(ChiSquare, QuantilesAreThoseOfTables) {
  // Abramowitz and Stegun, table 26.8.
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.84146, 1e-5);
  EXPECT_NEAR(chi_square_quantile(0.99, 2), 9.21034, 1e-5);
  EXPECT_NEAR(chi_square_quantile(0.999, 3), 16.266, 1e-3);
  EXPECT_NEAR(chi_square_quantile(0.95, 6), 12.5916, 1e-4);
  EXPECT_NEAR(kNormal95 * kNormal95, chi_square_quantile(0.95, 1), 1e-14);
  EXPECT_NEAR(chi_square_quantile(0.5, 15), 14.3389, 1e-4);
  for (int degrees = 1; degrees <= 20; ++degrees) {
    for (const double p : {0.001, 0.1, 0.9, 0.9999}) {
      EXPECT_NEAR(chi_square_probability(chi_square_quantile(p, degrees), degrees), p, 1e-9);
    }
  }
  EXPECT_THROW(static_cast<void>(chi_square_quantile(1, 3)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(chi_square_quantile(0.5, 0)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(chi_square_probability(-1, 3)), std::invalid_argument);
}

TEST(ChiSquare, DegreesMayBeMany) {
  EXPECT_NEAR(chi_square_quantile(0.95, 100), 124.342, 1e-3);
  EXPECT_NEAR(chi_square_quantile(0.025, 180), 144.741, 1e-3);
}

}  // namespace
}  // namespace pipescout::statistics
