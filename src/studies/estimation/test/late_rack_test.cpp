// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/late_rack.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace pipescout::estimation_study {
namespace {

TEST(LateRack, IsFoundAsWellAsByTheBatch) {
  constexpr int kSeeds = 4;
  double online = 0;
  double batch = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const LateRackScore score = score_late_rack({.duration = 20, .seen_from = 10}, seed);
    std::printf("seed %d: NEES on line %.2f, batch %.2f, %.3f m, %.4f rad, accepted %.2f\n",
                static_cast<int>(seed), score.online_nees, score.batch_nees, score.online_position,
                score.online_rotation, score.accepted_share);
    EXPECT_GT(score.accepted_share, 0.95);
    EXPECT_LT(score.online_position, 0.3);
    EXPECT_LT(score.online_rotation, 0.05);
    online += score.online_nees;
    batch += score.batch_nees;
  }
  EXPECT_LT(online, 1.3 * batch);
}

}  // namespace
}  // namespace pipescout::estimation_study
