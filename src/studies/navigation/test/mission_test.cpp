// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_study/mission.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace pipescout::navigation_study {
namespace {

/// Times of control cycles are none of a test's business.
double no_time() {
  return 0;
}

class MissionTest : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(MissionTest, ReachesItsGoalWithoutAContact) {
  const MissionScore score = run_mission({}, GetParam(), no_time);
  EXPECT_TRUE(score.reached) << to_string(score.failure) << ": " << score.text;
  EXPECT_EQ(score.collisions, 0U);
  EXPECT_LT(score.goal_distance, 0.2);
  EXPECT_LT(score.goal_heading, 5 * std::numbers::pi / 180);
}

INSTANTIATE_TEST_SUITE_P(Seeds, MissionTest, ::testing::Values(1, 2, 3));

TEST(Tour, SeesThePipesSharpAlsoWithAnExposureTwiceAsLong) {
  const MissionScore usual = run_mission({.time_limit = 2000, .tour = true}, 4, no_time);
  const MissionScore slow =
      run_mission({.time_limit = 2000, .tour = true, .exposure = 0.02}, 4, no_time);
  for (const MissionScore& score : {usual, slow}) {
    EXPECT_TRUE(score.reached) << to_string(score.failure) << ": " << score.text;
    EXPECT_EQ(score.collisions, 0U);
    EXPECT_GT(score.seen_percent, 99);
  }
  EXPECT_LT(slow.speed, 0.8 * usual.speed);
}

TEST(Mission, IsTheSameTwice) {
  const MissionScore first = run_mission({.time_limit = 30}, 5, no_time);
  const MissionScore second = run_mission({.time_limit = 30}, 5, no_time);
  EXPECT_EQ(first.driven, second.driven);
  EXPECT_EQ(first.least_clearance, second.least_clearance);
}

}  // namespace
}  // namespace pipescout::navigation_study
