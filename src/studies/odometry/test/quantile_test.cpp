// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/quantile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace pipescout::odometry_study {
namespace {

TEST(Quantile, IsTheLeastThatSoManyDoNotExceed) {
  std::vector<double> values(20);
  std::iota(values.rbegin(), values.rend(), 1.0);
  EXPECT_EQ(quantile(values, 0.0), 1.0);
  EXPECT_EQ(quantile(values, 0.05), 1.0);
  EXPECT_EQ(quantile(values, 0.5), 10.0);
  EXPECT_EQ(quantile(values, 0.95), 19.0);
  EXPECT_EQ(quantile(values, 1.0), 20.0);
  EXPECT_EQ(quantile({3.0}, 0.95), 3.0);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

}  // namespace
}  // namespace pipescout::odometry_study
