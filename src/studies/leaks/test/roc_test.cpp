// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/roc.hpp"

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

namespace pipescout::leak_study {
namespace {

TEST(Roc, CurveCountsWhatIsAboveEachThreshold) {
  const std::array leaks{0.0, 60.0, 70.0, 80.0};
  const std::array others{20.0, 65.0};
  const std::array thresholds{10.0, 65.0, 100.0};
  const auto curve = roc_curve(leaks, others, 500, thresholds);
  ASSERT_EQ(curve.size(), 3U);
  EXPECT_DOUBLE_EQ(curve[0].found_percent, 75);
  EXPECT_DOUBLE_EQ(curve[0].false_per_km, 4);
  EXPECT_DOUBLE_EQ(curve[1].found_percent, 50);
  EXPECT_DOUBLE_EQ(curve[1].false_per_km, 2);
  EXPECT_DOUBLE_EQ(curve[2].found_percent, 0);
  EXPECT_DOUBLE_EQ(curve[2].false_per_km, 0);
}

TEST(Roc, AreaIsTheProbabilityToRankALeakHigher) {
  const std::array leaks{50.0, 70.0};
  EXPECT_DOUBLE_EQ(roc_area(leaks, {}), 1);
  EXPECT_DOUBLE_EQ(roc_area(leaks, std::array{60.0}), 0.5);
  EXPECT_DOUBLE_EQ(roc_area(leaks, std::array{50.0, 10.0}), (0.5 + 1 + 1 + 1) / 4);
}

TEST(Roc, HotLeaksAreFoundThroughNoise) {
  const auto scores = run_roc({.rises = {100}, .netds = {0.1}, .leaks = 3, .decoys = 0}, {}, 1);
  ASSERT_EQ(scores.size(), 1U);
  EXPECT_EQ(scores[0].netd, 0.1);
  ASSERT_EQ(scores[0].of_leaks.size(), 1U);
  ASSERT_EQ(scores[0].of_leaks[0].size(), 3U);
  for (const double delta : scores[0].of_leaks[0]) {
    EXPECT_NEAR(delta, 100, 15);
  }
  EXPECT_THROW(static_cast<void>(run_roc({.leaks = 0}, {}, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::leak_study
