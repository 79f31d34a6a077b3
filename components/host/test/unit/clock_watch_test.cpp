// SPDX-License-Identifier: Apache-2.0
#include "core/clock_watch.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace pipescout::host {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class ClockWatchTest : public ::testing::Test {
 protected:
  /// A second later by the steady clock; that of the system was set meanwhile.
  std::optional<ClockStep> look(Duration set_by = Duration::zero()) {
    steady_ += seconds(1);
    system_ += seconds(1) + set_by;
    return watch_.look(system_, steady_);
  }

  ClockWatch watch_;
  SteadyTime steady_{seconds(50)};
  // 2026-11-29 07:45:10 UTC
  Time system_{std::chrono::sys_days(std::chrono::year(2026) / 11 / 29) + std::chrono::hours(7) +
               std::chrono::minutes(45) + seconds(8)};
};

TEST_F(ClockWatchTest, SaysWhichClockWasSetByHowMuchAndWhen) {
  EXPECT_FALSE(look());
  const auto step = look(-seconds(60));
  ASSERT_TRUE(step);
  EXPECT_EQ(step->by, -seconds(60));
  EXPECT_EQ(
      to_text(*step),
      "the system clock of this machine was set back by 60.0 s, from 2026-11-29T07:45:10.000Z "
      "to 2026-11-29T07:44:10.000Z: stamps go with it");
  EXPECT_FALSE(look()) << "it is told once";
}

TEST_F(ClockWatchTest, SaysThatItWasSetForward) {
  EXPECT_FALSE(look());
  const auto step = look(seconds(3600));
  ASSERT_TRUE(step);
  EXPECT_EQ(to_text(*step),
            "the system clock of this machine was set forward by 3600.0 s, from "
            "2026-11-29T07:45:10.000Z to 2026-11-29T08:45:10.000Z: stamps go with it");
}

TEST_F(ClockWatchTest, AClockThatIsDisciplinedIsNotSet) {
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(
        look(i % 2 == 0 ? std::chrono::microseconds(500) : -std::chrono::microseconds(500)));
  }
  // A machine that sleeps, or a process that is stopped, looks later.
  steady_ += seconds(600);
  system_ += seconds(600);
  EXPECT_FALSE(look());
}

}  // namespace
}  // namespace pipescout::host
