// SPDX-License-Identifier: Apache-2.0
#include "../src/turn_window.hpp"

#include <gtest/gtest.h>

namespace pipescout::estimation {
namespace {

TEST(TurnWindow, MeanIsOfTheIntervalsThatAreAskedFor) {
  TurnWindow window(0.1, 20);
  EXPECT_EQ(window.mean(0, 1), 0);
  for (int i = 0; i < 10; ++i) {
    window.add(0.05 + 0.1 * i, i);
  }
  EXPECT_DOUBLE_EQ(window.mean(0.21, 0.45), 3);
  EXPECT_DOUBLE_EQ(window.mean(-5, 5), 4.5);
  EXPECT_EQ(window.mean(1.2, 1.5), 0);
}

TEST(TurnWindow, WhatIsAheadWaitsAndWhatIsTooOldIsNotKept) {
  TurnWindow window(0.1, 10);
  window.add(0.85, 2);
  window.add(0.05, 1);  // late
  EXPECT_DOUBLE_EQ(window.mean(0, 0.09), 1);
  EXPECT_DOUBLE_EQ(window.mean(0.8, 0.89), 2);
  window.add(1.05, 3);  // in the place of the oldest
  window.add(0.06, 9);
  EXPECT_EQ(window.mean(0, 0.09), 0);
  EXPECT_DOUBLE_EQ(window.mean(1.0, 1.09), 3);
  window.forget();
  EXPECT_EQ(window.mean(0, 2), 0);
}

TEST(TurnWindow, TimesBeforeZeroAndBeyondAllIntervalsAreHarmless) {
  TurnWindow window(0.1, 10);
  window.add(-0.05, 4);
  EXPECT_DOUBLE_EQ(window.mean(-0.1, -0.01), 4);
  window.add(1e300, 5);
  EXPECT_EQ(window.mean(0, 1e300), 0);
}

}  // namespace
}  // namespace pipescout::estimation
