// SPDX-License-Identifier: Apache-2.0
#include "pipescout/testing/action_race.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout {
namespace {

TEST(ActionThreads, CancellationsThatRaceWithTheEndLoseNoGoalAndContradictNone) {
  constexpr std::size_t kGoals = 2000;
  const auto context = Context::create_in_process();
  const auto report = testing::race_actions(context, context, {.goals = kGoals});
  EXPECT_EQ(report.lost, 0U);
  EXPECT_EQ(report.wrong, 0U) << ::testing::PrintToString(report.faults);
  EXPECT_EQ(report.succeeded + report.canceled, kGoals);
}

}  // namespace
}  // namespace pipescout
