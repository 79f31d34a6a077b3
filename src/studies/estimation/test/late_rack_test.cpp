// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/late_rack.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace pipescout::estimation_study {
namespace {

TEST(LateRack, IsFoundAndItsPosesAreAccepted) {
  constexpr int kSeeds = 4;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const LateRackScore score =
        score_late_rack(fly_to_late_rack({.duration = 20, .seen_from = 10}, seed));
    std::printf("seed %d: NEES %.2f, %.3f m, %.4f rad, accepted %.2f\n", static_cast<int>(seed),
                score.nees, score.position, score.rotation, score.accepted_share);
    EXPECT_GT(score.accepted_share, 0.95);
    EXPECT_LT(score.position, 0.3);
    EXPECT_LT(score.rotation, 0.05);
  }
}

}  // namespace
}  // namespace pipescout::estimation_study
