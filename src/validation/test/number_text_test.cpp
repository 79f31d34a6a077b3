// SPDX-License-Identifier: Apache-2.0
#include "pipescout/validation/number_text.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace pipescout::validation {
namespace {

TEST(NumberText, HasNoDigitsThatSayNothing) {
  EXPECT_EQ(number_text(0.5), "0.5");
  EXPECT_EQ(number_text(-2), "-2");
  EXPECT_EQ(number_text(0.1 + 0.2), "0.3");
  EXPECT_EQ(number_text(52.123456), "52.123456");
  EXPECT_EQ(number_text(1e-9), "1e-09");
  EXPECT_EQ(number_text(std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(number_text(-std::numeric_limits<double>::infinity()), "-inf");
  EXPECT_EQ(number_text(-std::numeric_limits<double>::max()), "-1.79769313e+308");
}

TEST(FixedText, HasTheDigitsAskedFor) {
  EXPECT_EQ(fixed_text(0.5, 2), "0.50");
  EXPECT_EQ(fixed_text(12.349, 1), "12.3");
  EXPECT_EQ(fixed_text(2.6, 0), "3");
  EXPECT_EQ(fixed_text(-0.04, 1), "0.0");
  EXPECT_EQ(fixed_text(-0.06, 1), "-0.1");
  EXPECT_EQ(fixed_text(std::numeric_limits<double>::quiet_NaN(), 1), "nan");
  EXPECT_EQ(fixed_text(-std::numeric_limits<double>::max(), 15).size(), 326U);
}

}  // namespace
}  // namespace pipescout::validation
