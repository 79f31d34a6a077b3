// SPDX-License-Identifier: Apache-2.0
#include "core/mission_progress.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace pipescout::host {
namespace {

using State = ComponentReport::State;
using Outcome = MissionProgress::Outcome;
using std::chrono::milliseconds;

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
  progress.report(kFusion, {State::kRunning, 5, 4, ""});
  EXPECT_EQ(progress.outcome(), Outcome::kComplete);
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

TEST(ProgressPrinter, RewritesOneLineOnATerminal) {
  std::ostringstream out;
  ProgressPrinter printer(out, true);
  SteadyTime now{};
  printer.show("1/3", 0.3, now);
  printer.show("2/3", 0.6, now + milliseconds(50));
  EXPECT_EQ(out.str(), "\r\x1b[K1/3\r");
  EXPECT_EQ(printer.due(), now + milliseconds(100));
  printer.show("2/3", 0.6, now + milliseconds(100));
  EXPECT_FALSE(printer.due());
  EXPECT_EQ(out.str(), "\r\x1b[K1/3\r\r\x1b[K2/3\r");
  printer.show("3/3", 1.0, now + milliseconds(110));
  printer.finish();
  EXPECT_EQ(out.str(), "\r\x1b[K1/3\r\r\x1b[K2/3\r\r\x1b[K3/3\r\n");
}

TEST(ProgressPrinter, PrintsFewLinesElsewhere) {
  std::ostringstream out;
  ProgressPrinter printer(out, false);
  // A minute, in which 1 % is done every 100 ms for ten seconds, then nothing.
  SteadyTime now{};
  for (int percent = 0; percent <= 100; ++percent) {
    printer.show(std::to_string(percent), percent / 100.0, now);
    now += milliseconds(100);
  }
  for (int i = 0; i < 500; ++i) {
    printer.show("100", 1.0, now);
    now += milliseconds(100);
  }
  printer.finish();
  EXPECT_EQ(out.str(), "0\n10\n20\n30\n40\n50\n60\n70\n80\n90\n100\n");
}

TEST(ProgressPrinter, PrintsOncePerSecondWhenTheShareIsUnknown) {
  std::ostringstream out;
  ProgressPrinter printer(out, false);
  SteadyTime now{};
  for (int i = 0; i < 25; ++i) {
    printer.show(std::to_string(i), std::nullopt, now);
    now += milliseconds(100);
  }
  printer.finish();
  EXPECT_EQ(out.str(), "0\n10\n20\n24\n");
}

TEST(ProgressPrinter, ShowsNothingOfNothing) {
  std::ostringstream out;
  ProgressPrinter printer(out, true);
  printer.show("", std::nullopt, SteadyTime{});
  printer.finish();
  EXPECT_EQ(out.str(), "");
}

}  // namespace
}  // namespace pipescout::host
