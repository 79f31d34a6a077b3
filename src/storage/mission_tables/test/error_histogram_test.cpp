// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_tables/error_histogram.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pipescout {
namespace {

TEST(ErrorHistogram, QuantilesToHalfAPercent) {
  ErrorHistogram histogram;
  for (int k = 1; k <= 10000; ++k) {
    histogram.add((k % 2 == 0 ? 1e-5 : -1e-5) * k);
  }
  EXPECT_EQ(histogram.count(), 10000U);
  EXPECT_NEAR(histogram.quantile(0.5), 0.05, 0.05 * 0.006);
  EXPECT_NEAR(histogram.quantile(0.95), 0.095, 0.095 * 0.006);
  EXPECT_DOUBLE_EQ(histogram.quantile(1.0), histogram.largest());
  EXPECT_DOUBLE_EQ(histogram.largest(), 0.1);
  EXPECT_NEAR(histogram.root_mean_square(), 0.1 / std::sqrt(3.0), 1e-5);
}

TEST(ErrorHistogram, Extremes) {
  ErrorHistogram histogram;
  EXPECT_TRUE(std::isnan(histogram.quantile(0.5)));
  EXPECT_TRUE(std::isnan(histogram.largest()));
  EXPECT_TRUE(std::isnan(histogram.root_mean_square()));
  histogram.add(std::numeric_limits<double>::quiet_NaN());
  histogram.add(std::numeric_limits<double>::infinity());
  EXPECT_EQ(histogram.count(), 0U);
  histogram.add(0.0);
  EXPECT_EQ(histogram.quantile(0.5), 0.0);
  histogram.add(1e9);
  EXPECT_EQ(histogram.largest(), 1e9);
  EXPECT_LE(histogram.quantile(1.0), 1e9);
}

}  // namespace
}  // namespace pipescout
