// SPDX-License-Identifier: Apache-2.0
#include "core/rate_window.hpp"

#include <gtest/gtest.h>

namespace pipescout::host {
namespace {

using std::chrono::milliseconds;

TEST(RateWindow, MeasuresIntervals) {
  RateWindow window(3);
  SteadyTime now{};
  EXPECT_FALSE(window.statistics());
  window.arrived(now);
  EXPECT_FALSE(window.statistics());
  for (const int wait : {1000, 50, 100, 150}) {
    now += milliseconds(wait);
    window.arrived(now);
  }
  const auto statistics = window.statistics();
  ASSERT_TRUE(statistics);
  EXPECT_DOUBLE_EQ(statistics->rate, 10.0);
  EXPECT_EQ(to_string(*statistics),
            "average rate: 10.000\n\tmin: 0.050s max: 0.150s std dev: 0.04082s window: 3");
}

TEST(RateWindow, NeedsAWindow) {
  EXPECT_THROW(RateWindow(0), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::host
