// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/timer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pipescout {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr Duration kLong = seconds(30);

Time at(double seconds_since_start) {
  return Time(from_seconds(seconds_since_start));
}

TEST(TimeConversion, RoundsSaturatesAndTakesNaNForZero) {
  EXPECT_EQ(from_seconds(0.5), milliseconds(500));
  EXPECT_EQ(from_seconds(-1e-9), Duration(-1));
  EXPECT_EQ(from_seconds(1e300), Duration::max());
  EXPECT_EQ(from_seconds(-1e300), Duration::min());
  EXPECT_EQ(from_seconds(std::numeric_limits<double>::quiet_NaN()), Duration::zero());
  EXPECT_DOUBLE_EQ(to_seconds(milliseconds(1500)), 1.5);
}

TEST(TimeConversion, SumsSaturate) {
  EXPECT_EQ(add_saturated(at(1.0), seconds(2)), at(3.0));
  EXPECT_EQ(add_saturated(at(1.0), Duration::max()), Time::max());
  EXPECT_EQ(add_saturated(at(-1.0), Duration::max()), Time(Duration::max() - seconds(1)));
}

TEST(Timer, RefusesAPeriodThatIsNotPositive) {
  Executor executor;
  const auto group = executor.create_callback_group();
  for (const Duration period : {Duration::zero(), Duration(-1)}) {
    try {
      const Timer timer(group, period, [] {});
      FAIL();
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(std::to_string(period.count()) + " ns"));
    }
  }
}

TEST(Timer, FiresAgainAndAgainOnTheSteadyClock) {
  Executor executor;
  int calls = 0;
  const Timer timer(executor.create_callback_group(), milliseconds(1), [&] { ++calls; });
  EXPECT_EQ(timer.period(), milliseconds(1));
  EXPECT_EQ(calls, 0);
  EXPECT_TRUE(executor.spin_until([&] { return calls == 3; }, kLong));
}

TEST(Timer, GoesOnAfterItsCallbackThrew) {
  Executor executor;
  const auto group = executor.create_callback_group();
  group->set_exception_handler([](std::exception_ptr) {});
  int calls = 0;
  const Timer timer(group, milliseconds(1), [&] {
    ++calls;
    throw std::runtime_error("broken");
  });
  EXPECT_TRUE(executor.spin_until([&] { return calls == 2; }, kLong));
}

TEST(Timer, TakesTheLongestPeriod) {
  Executor executor;
  const auto clock = std::make_shared<SimulatedClock>();
  clock->set(at(1.0));
  const auto group = executor.create_callback_group();
  const Timer steady(group, Duration::max(), [] { FAIL(); });
  const Timer simulated(
      group, Duration::max(), [] { FAIL(); }, clock);
  clock->set(at(1e6));
  EXPECT_EQ(executor.spin_ready(), 0U);
}

/// Everything a simulated clock drives is exact.
class SimulatedTimer : public ::testing::Test {
 protected:
  std::vector<double> run_to(double seconds_since_start) {
    calls_.clear();
    clock_->set(at(seconds_since_start));
    executor_.spin_ready();
    return calls_;
  }
  Timer make(Duration period) {
    return Timer(
        group_, period, [this] { calls_.push_back(to_seconds(clock_->now() - Time{})); }, clock_);
  }

  Executor executor_;
  std::shared_ptr<CallbackGroup> group_ = executor_.create_callback_group();
  std::shared_ptr<SimulatedClock> clock_ = std::make_shared<SimulatedClock>();
  std::vector<double> calls_;
};

TEST_F(SimulatedTimer, FollowsTheClockAndNothingElse) {
  const Timer timer = make(seconds(1));
  EXPECT_TRUE(clock_->is_simulated());
  EXPECT_THAT(run_to(0.9), ElementsAre());
  EXPECT_THAT(run_to(1.0), ElementsAre(1.0));
  EXPECT_THAT(run_to(1.0), ElementsAre());
  EXPECT_THAT(run_to(2.5), ElementsAre(2.5));
}

TEST_F(SimulatedTimer, SkipsMissedPeriodsAndKeepsItsPhase) {
  const Timer timer = make(seconds(1));
  EXPECT_THAT(run_to(7.3), ElementsAre(7.3));
  EXPECT_THAT(run_to(7.9), ElementsAre());
  EXPECT_THAT(run_to(8.0), ElementsAre(8.0));
}

TEST_F(SimulatedTimer, StartsAgainAfterAJumpBack) {
  const Timer timer = make(seconds(1));
  EXPECT_THAT(run_to(100.0), ElementsAre(100.0));
  EXPECT_THAT(run_to(10.5), ElementsAre());
  EXPECT_THAT(run_to(11.4), ElementsAre());
  EXPECT_THAT(run_to(11.5), ElementsAre(11.5));
}

TEST_F(SimulatedTimer, ASmallJumpBackDoesNotDelayItBeyondItsTime) {
  const Timer timer = make(seconds(10));
  EXPECT_THAT(run_to(9.0), ElementsAre());
  EXPECT_THAT(run_to(8.0), ElementsAre());
  EXPECT_THAT(run_to(10.0), ElementsAre(10.0));
}

TEST_F(SimulatedTimer, DisabledItIsSilentAndEnabledItStartsANewPeriod) {
  Timer timer = make(seconds(1));
  timer.set_enabled(false);
  EXPECT_THAT(run_to(5.5), ElementsAre());
  timer.set_enabled(true);
  EXPECT_THAT(run_to(6.4), ElementsAre());
  EXPECT_THAT(run_to(6.5), ElementsAre(6.5));
}

TEST_F(SimulatedTimer, DisablingReachesWorkThatIsQueuedAlready) {
  Timer timer = make(seconds(1));
  clock_->set(at(1.0));
  timer.set_enabled(false);
  executor_.spin_ready();
  EXPECT_THAT(calls_, ElementsAre());
}

TEST_F(SimulatedTimer, ResetStartsThePeriodAgain) {
  Timer timer = make(seconds(1));
  EXPECT_THAT(run_to(0.5), ElementsAre());
  timer.reset();
  EXPECT_THAT(run_to(1.4), ElementsAre());
  EXPECT_THAT(run_to(1.5), ElementsAre(1.5));
  timer.set_enabled(false);
  timer.reset();
  EXPECT_THAT(run_to(9.0), ElementsAre());
}

TEST_F(SimulatedTimer, StopsWhenItsHandleGoesOrIsReplaced) {
  Timer timer = make(seconds(1));
  timer = make(seconds(10));
  EXPECT_THAT(run_to(5.0), ElementsAre());
  EXPECT_THAT(run_to(10.0), ElementsAre(10.0));
  { const Timer gone = std::move(timer); }
  EXPECT_THAT(run_to(20.0), ElementsAre());
}

TEST_F(SimulatedTimer, TheOldTimerEndsWhenAnotherIsMovedOverIt) {
  Timer first = make(seconds(1));
  Timer second = make(seconds(10));
  first = std::move(second);
  EXPECT_THAT(run_to(5.0), ElementsAre());
}

TEST_F(SimulatedTimer, MayDestroyItselfInItsCallback) {
  std::unique_ptr<Timer> timer;
  int calls = 0;
  timer = std::make_unique<Timer>(
      group_, seconds(1),
      [&] {
        ++calls;
        timer.reset();
      },
      clock_);
  run_to(1.0);
  run_to(2.0);
  EXPECT_EQ(calls, 1);
}

TEST_F(SimulatedTimer, TimersOfOneTimeFireInTheOrderOfTheirTimes) {
  std::vector<int> order;
  std::vector<Timer> timers;
  for (const int i : {3, 1, 2}) {
    timers.emplace_back(
        group_, seconds(i), [&order, i] { order.push_back(i); }, clock_);
  }
  timers.emplace_back(
      group_, seconds(2), [&order] { order.push_back(20); }, clock_);
  clock_->set(at(3.0));
  executor_.spin_ready();
  EXPECT_THAT(order, ElementsAre(1, 2, 20, 3));
}

TEST_F(SimulatedTimer, MovesToAnotherClock) {
  int calls = 0;
  Timer timer(
      group_, seconds(2), [&calls] { ++calls; }, clock_);
  clock_->set(at(1.0));
  const auto other = std::make_shared<SimulatedClock>();
  other->set(at(100.0));
  timer.follow(other);
  clock_->set(at(50.0));
  EXPECT_EQ(executor_.spin_ready(), 0U);
  other->set(at(101.5));
  EXPECT_EQ(executor_.spin_ready(), 0U);
  other->set(at(102.0));
  EXPECT_EQ(executor_.spin_ready(), 1U);
  EXPECT_EQ(calls, 1);

  timer.set_enabled(false);
  timer.follow(nullptr);
  other->set(at(200.0));
  EXPECT_EQ(executor_.spin_ready(), 0U);
  timer.follow(clock_);
  timer.set_enabled(true);
  clock_->set(at(52.0));
  EXPECT_EQ(executor_.spin_ready(), 1U);
  EXPECT_EQ(calls, 2);
}

TEST(SimulatedClock, ListensToOneOfSeveralSourcesWhileItExists) {
  SimulatedClock clock;
  auto first = std::make_shared<int>();
  const auto second = std::make_shared<int>();
  clock.set_from(first, at(1.0));
  clock.set_from(second, at(0.5));
  EXPECT_EQ(clock.now(), at(1.0));
  clock.set_from(first, at(2.0));
  EXPECT_EQ(clock.now(), at(2.0));
  first.reset();
  clock.set_from(second, at(3.0));
  EXPECT_EQ(clock.now(), at(3.0));
}

TEST(SystemClock, IsNotSimulatedAndRunsForward) {
  const SystemClock clock;
  EXPECT_FALSE(clock.is_simulated());
  EXPECT_GT(clock.now(), Time{});
}

TEST(SimulatedClock, ForgetsWhatIsCancelledOrGone) {
  struct Never final : Waitable {
    void execute() override { FAIL(); }
  };
  Executor executor;
  const auto group = executor.create_callback_group();
  SimulatedClock clock;
  const auto cancelled = std::make_shared<Never>();
  clock.schedule_at(at(1.0), group, cancelled);
  clock.cancel(cancelled.get());
  clock.schedule_at(at(1.0), group, std::make_shared<Never>());
  clock.set(at(2.0));
  EXPECT_EQ(executor.spin_ready(), 0U);
}

}  // namespace
}  // namespace pipescout
