// SPDX-License-Identifier: Apache-2.0
#include "core/mission_progress.hpp"

#include <gtest/gtest.h>

namespace pipescout::host {
namespace {

using State = ComponentReport::State;
using Outcome = MissionProgress::Outcome;

const NodeName kReplay{"/", "replay"};
const NodeName kFusion{"/", "fusion"};

TEST(MissionProgress, IsCompleteWhenAllAwaitedAre) {
  MissionProgress progress({kReplay, kFusion});
  EXPECT_EQ(progress.outcome(), Outcome::kRunning);
  EXPECT_EQ(progress.line(), "");
  progress.report(kReplay, {State::kRunning, 5, 10, ""});
  progress.report(kReplay, {State::kComplete, 0, 0, ""});
  EXPECT_EQ(progress.outcome(), Outcome::kRunning);
  progress.report(kFusion, {State::kRunning, 3, 4, ""});
  EXPECT_EQ(progress.line(), "75 %  fusion 3/4  replay 5/10");
  progress.report(kFusion, {State::kComplete, 4, 4, ""});
  EXPECT_EQ(progress.outcome(), Outcome::kComplete);
  EXPECT_EQ(progress.fraction(), 1.0);
  EXPECT_EQ(progress.line(), "finished  fusion 4/4  replay 5/10");
  progress.report(kFusion, {State::kRunning, 5, 4, ""});
  EXPECT_EQ(progress.outcome(), Outcome::kComplete);
}

TEST(MissionProgress, SaysOfWhomNobodyWaitedForThatItStopped) {
  MissionProgress progress({kFusion});
  progress.report(kReplay, {State::kRunning, 990, 4500, ""});
  progress.report(kFusion, {State::kRunning, 4, 4, ""});
  EXPECT_EQ(progress.line(), "100 %  fusion 4/4  replay 990/4500");
  progress.report(kFusion, {State::kComplete, 4, 4, ""});
  EXPECT_EQ(progress.line(), "finished  fusion 4/4  replay stopped at 990");
}

TEST(MissionProgress, IsNeverCompleteWhenNothingIsAwaited) {
  MissionProgress progress({});
  progress.report(kReplay, {State::kComplete, 1, 1, ""});
  EXPECT_EQ(progress.outcome(), Outcome::kRunning);
  EXPECT_FALSE(progress.fraction());
}

TEST(MissionProgress, FailsWithAnyComponent) {
  MissionProgress progress({kFusion});
  progress.report(kFusion, {State::kComplete, 1, 1, ""});
  progress.report(kReplay, {State::kFailed, 0, 0, "no file"});
  EXPECT_EQ(progress.outcome(), Outcome::kFailed);
  EXPECT_EQ(progress.failure(), "/replay failed: no file");
}

TEST(MissionProgress, KnowsNoShareWithoutTotals) {
  MissionProgress progress({kReplay});
  progress.report(kReplay, {State::kRunning, 7, 0, ""});
  EXPECT_FALSE(progress.fraction());
  EXPECT_EQ(progress.line(), "replay 7");
  progress.report(kReplay, {State::kRunning, 12, 10, ""});
  EXPECT_EQ(progress.fraction(), 1.0);
}

TEST(MissionProgress, KeepsComponentsOfTwoNamespacesApart) {
  MissionProgress progress({NodeName{"/a", "fusion"}});
  progress.report({"/b", "fusion"}, {State::kComplete, 0, 0, ""});
  EXPECT_EQ(progress.outcome(), Outcome::kRunning);
}

}  // namespace
}  // namespace pipescout::host
