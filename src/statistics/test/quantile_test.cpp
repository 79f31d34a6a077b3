// SPDX-License-Identifier: Apache-2.0
#include "pipescout/statistics/quantile.hpp"

#include <gtest/gtest.h>

namespace pipescout::statistics {
namespace {

TEST(QuantileInPlace, LiesAtItsShareOfTheOrder) {
  std::vector<double> values{5, 1, 4, 2, 3};
  EXPECT_EQ(quantile_in_place(values, 0), 1);
  EXPECT_EQ(quantile_in_place(values, 0.25), 2);
  EXPECT_EQ(quantile_in_place(values, 1), 5);
}

TEST(QuantileInPlace, BetweenTwoValuesIsTheSmaller) {
  std::vector<float> values{4, 3, 2, 1};
  EXPECT_EQ(quantile_in_place(values, 0.5), 2);
}

}  // namespace
}  // namespace pipescout::statistics
