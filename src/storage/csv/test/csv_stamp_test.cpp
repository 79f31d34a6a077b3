// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_stamp.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>

namespace pipescout {
namespace {

using std::chrono::nanoseconds;

TEST(Stamp, ExactUpToNineDecimals) {
  EXPECT_EQ(parse_stamp("0"), nanoseconds(0));
  EXPECT_EQ(parse_stamp("12."), nanoseconds(12'000'000'000));
  EXPECT_EQ(parse_stamp("12.000000345"), nanoseconds(12'000'000'345));
  EXPECT_EQ(parse_stamp("2147483647.999999999"), nanoseconds(2'147'483'647'999'999'999));
  EXPECT_EQ(parse_stamp("1.5e1"), nanoseconds(15'000'000'000));
  EXPECT_EQ(parse_stamp("0.12345678912"), nanoseconds(123'456'789));
  for (const char* text :
       {"", ".", "-0.1", "2147483648", "1e10", "inf", "nan", "99999999999999999999", "1:30"}) {
    EXPECT_EQ(parse_stamp(text), std::nullopt) << text;
  }
}

TEST(Stamp, FormattedWithNineDecimals) {
  EXPECT_EQ(format_stamp(nanoseconds(12'000'000'345)), "12.000000345");
  EXPECT_EQ(format_stamp(nanoseconds(-1)), "-0.000000001");
}

}  // namespace
}  // namespace pipescout
