// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_tables/thinning.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
namespace pipescout {
namespace {

std::chrono::nanoseconds seconds_long(double seconds) {
  return std::chrono::nanoseconds(std::llround(seconds * 1e9));
}

Stamp at(double seconds) {
  return Stamp{} + seconds_long(seconds);
}

int kept(double period, double interval, int messages) {
  Thinning thinning(seconds_long(period));
  int result = 0;
  for (int k = 0; k < messages; ++k) {
    if (thinning.due(at(k * interval))) {
      thinning.keep(at(k * interval));
      ++result;
    }
  }
  return result;
}

TEST(Thinning, OneInEachPeriod) {
  EXPECT_EQ(kept(0.1, 0.005, 201), 11) << "exactly every 20th";
  EXPECT_EQ(kept(0.1, 1.0 / 30.0, 301), 101) << "every third, whatever rounding makes of it";
  EXPECT_EQ(kept(0.1, 0.25, 100), 100);
  EXPECT_EQ(kept(0.0, 0.005, 100), 100);
}

TEST(Thinning, OneThatIsNotKeptDoesNotCount) {
  Thinning thinning(seconds_long(1.0));
  EXPECT_TRUE(thinning.due(at(1.0)));
  EXPECT_TRUE(thinning.due(at(1.1)));
  thinning.keep(at(1.1));
  EXPECT_FALSE(thinning.due(at(2.0)));
  EXPECT_TRUE(thinning.due(at(2.095))) << "the stream has another clock";
  EXPECT_TRUE(thinning.due(at(0.5))) << "the clock began again";
}

}  // namespace
}  // namespace pipescout
