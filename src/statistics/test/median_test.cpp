// SPDX-License-Identifier: Apache-2.0
#include "pipescout/statistics/median.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace pipescout::statistics {
namespace {

TEST(Median, IsTheMiddleValueOfAnyOrder) {
  EXPECT_EQ(median<double>({3, 1, 2}), 2);
  EXPECT_EQ(median<std::uint16_t>({7}), 7);
}

TEST(Median, CanReorderInsteadOfCopying) {
  std::vector<double> values{5, 1, 4, 2};
  EXPECT_EQ(median_in_place(values), 4);
  EXPECT_EQ(values.size(), 4U);
}

TEST(Median, OfTwoMiddleValuesIsTheLarger) {
  EXPECT_EQ(median<double>({4, 1, 3, 2}), 3);
}

}  // namespace
}  // namespace pipescout::statistics
