// SPDX-License-Identifier: Apache-2.0
#include "pipescout/recording/thinning.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

Time at(double seconds) {
  return Time{} + from_seconds(seconds);
}

int kept(double period, double interval, int messages) {
  Thinning thinning(from_seconds(period));
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
  Thinning thinning(from_seconds(1.0));
  EXPECT_TRUE(thinning.due(at(1.0)));
  EXPECT_TRUE(thinning.due(at(1.1)));
  thinning.keep(at(1.1));
  EXPECT_FALSE(thinning.due(at(2.0)));
  EXPECT_TRUE(thinning.due(at(2.095))) << "the stream has another clock";
  EXPECT_TRUE(thinning.due(at(0.5))) << "the clock began again";
}

}  // namespace
}  // namespace pipescout
