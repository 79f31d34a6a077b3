// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking_study/crossing_score.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace pipescout::tracking_study {
namespace {

TEST(CrossingScore, NoTrackChangesTheTube) {
  CrossingScore total;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    total += score_crossing({}, {}, seed);
  }
  std::printf("%zu crossings, tracked tube hidden in %zu: %zu swaps, %zu lost\n", total.crossings,
              total.tracked_hidden, total.swaps, total.lost);
  EXPECT_EQ(total.crossings, 200U);
  EXPECT_GT(total.tracked_hidden, 60U);
  EXPECT_EQ(total.swaps, 0U);
}

TEST(CrossingScore, NothingHiddenNothingChanged) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CrossingSettings settings;
    settings.hidden = 0.0;
    settings.parallel_share = 0.0;
    EXPECT_EQ(score_crossing({}, settings, seed).swaps, 0U) << seed;
  }
}

}  // namespace
}  // namespace pipescout::tracking_study
