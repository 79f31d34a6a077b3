// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/executor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <future>
#include <latch>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace pipescout {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;

constexpr Duration kLong = seconds(30);

class Work final : public Waitable {
 public:
  explicit Work(std::function<void()> function) : function_(std::move(function)) {}
  void execute() override { function_(); }

 private:
  const std::function<void()> function_;
};

/// Runs `spin` on a thread of its own until it goes.
class Spinning {
 public:
  explicit Spinning(Executor& executor)
      : executor_(executor), thread_([&executor] { executor.spin(); }) {}
  Spinning(const Spinning&) = delete;
  Spinning& operator=(const Spinning&) = delete;
  ~Spinning() {
    executor_.stop();
    thread_.join();
  }

 private:
  Executor& executor_;
  std::thread thread_;
};

TEST(Executor, RefusesAThreadCountOutOfRange) {
  EXPECT_THROW(Executor(0), std::invalid_argument);
  EXPECT_THROW(Executor(257), std::invalid_argument);
  EXPECT_EQ(Executor(4).threads(), 4U);
}

TEST(Executor, RunsWorkOfAllGroupsInOrderOfArrival) {
  Executor executor;
  const auto a = executor.create_callback_group();
  const auto b = executor.create_callback_group(CallbackGroupType::kReentrant);
  std::vector<int> order;
  for (int i = 0; i < 6; ++i) {
    // Three in a row for one group, then in turn.
    (i < 3 || i % 2 == 0 ? a : b)->post([&order, i] { order.push_back(i); });
  }
  EXPECT_EQ(executor.spin_ready(), 6U);
  EXPECT_THAT(order, ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(Executor, WorkThatFollowsItselfDoesNotStarveOthers) {
  Executor executor;
  const auto busy = executor.create_callback_group();
  const auto quiet = executor.create_callback_group();
  int busy_runs = 0;
  int busy_runs_at_quiet = -1;
  std::function<void()> again = [&] {
    if (++busy_runs < 100) {
      busy->post(again);
    }
  };
  busy->post(again);
  quiet->post([&] { busy_runs_at_quiet = busy_runs; });
  executor.spin_ready();
  EXPECT_EQ(busy_runs, 100);
  EXPECT_EQ(busy_runs_at_quiet, 1);
}

TEST(Executor, SpinReadyNeverWaits) {
  Executor executor;
  const auto group = executor.create_callback_group();
  const auto later = std::make_shared<Work>([] { FAIL(); });
  group->schedule_at(steady_now() + hours(1), later);
  EXPECT_EQ(executor.spin_ready(), 0U);
}

TEST(Executor, StopBeforeSpinEndsItAtOnceAndOnlyOnce) {
  Executor executor;
  const auto group = executor.create_callback_group();
  executor.stop();
  executor.spin();
  group->post([&] { executor.stop(); });
  executor.spin();
  EXPECT_EQ(executor.spin_ready(), 0U);
}

TEST(Executor, SpinUntilStopsWhenDone) {
  Executor executor;
  const auto group = executor.create_callback_group();
  int runs = 0;
  for (int i = 0; i < 5; ++i) {
    group->post([&] { ++runs; });
  }
  EXPECT_TRUE(executor.spin_until([&] { return runs == 3; }, kLong));
  EXPECT_EQ(runs, 3);
  EXPECT_EQ(executor.spin_ready(), 2U);
}

TEST(Executor, SpinUntilEndsWhenTheTimeIsOver) {
  Executor executor;
  EXPECT_FALSE(executor.spin_until([] { return false; }, milliseconds(1)));
  EXPECT_FALSE(executor.spin_until([] { return false; }, Duration::zero()));
}

TEST(Executor, SpinUntilTakesTheLongestTimeout) {
  Executor executor;
  const auto group = executor.create_callback_group();
  bool ran = false;
  std::thread other([&] { group->post([&] { ran = true; }); });
  EXPECT_TRUE(executor.spin_until([&] { return ran; }, Duration::max()));
  other.join();
}

TEST(Executor, SpinUntilIsEndedByStop) {
  Executor executor;
  const auto group = executor.create_callback_group();
  group->post([&] { executor.stop(); });
  EXPECT_FALSE(executor.spin_until([] { return false; }, kLong));
  bool ran = false;
  group->post([&] { ran = true; });
  EXPECT_TRUE(executor.spin_until([&] { return ran; }, kLong));
}

/// Starts a second thread in `spin` from within a callback, and returns once that thread has run
/// something and is about to sleep.
std::unique_ptr<Spinning> spin_beside(Executor& executor) {
  auto beside = std::make_unique<Spinning>(executor);
  std::promise<void> awake;
  executor.create_callback_group()->post([&awake] { awake.set_value(); });
  awake.get_future().wait();
  return beside;
}

TEST(Executor, WorkThatIsLeftWhenSpinUntilEndsIsDoneByAnotherThread) {
  for (int round = 0; round < 20; ++round) {
    Executor executor;
    const auto group = executor.create_callback_group();
    std::unique_ptr<Spinning> beside;
    std::promise<void> ran;
    group->post([&] {
      beside = spin_beside(executor);
      // Waits for this callback, and the other thread sleeps meanwhile.
      group->post([&ran] { ran.set_value(); });
    });
    EXPECT_TRUE(executor.spin_until([&] { return beside != nullptr; }, kLong));
    ASSERT_EQ(ran.get_future().wait_for(kLong), std::future_status::ready) << round;
  }
}

TEST(Executor, TimersGoOnWhenTheThreadThatWaitedForThemLeaves) {
  for (int round = 0; round < 5; ++round) {
    Executor executor;
    const auto group = executor.create_callback_group();
    std::promise<void> ran;
    const auto timed = std::make_shared<Work>([&ran] { ran.set_value(); });
    group->schedule_at(steady_now() + milliseconds(40), timed);
    std::thread leaving([&] { executor.spin_until([] { return false; }, milliseconds(20)); });
    const auto beside = spin_beside(executor);
    leaving.join();
    ASSERT_EQ(ran.get_future().wait_for(kLong), std::future_status::ready) << round;
  }
}

TEST(Executor, StopReachesEveryThreadThatSpins) {
  for (int round = 0; round < 20; ++round) {
    Executor executor;
    const auto group = executor.create_callback_group();
    std::future<void> other;
    group->post([&] {
      std::promise<void> awake;
      other = std::async(std::launch::async, [&executor] { executor.spin(); });
      executor.create_callback_group()->post([&awake] { awake.set_value(); });
      awake.get_future().wait();
      executor.stop();
    });
    // Its end must not take back what was asked of the other.
    EXPECT_TRUE(executor.spin_until([&] { return other.valid(); }, kLong));
    const auto ended = other.wait_for(kLong);
    executor.stop();
    ASSERT_EQ(ended, std::future_status::ready) << round;
  }
}

TEST(Executor, AFailureEndsTheSpinThatRanIntoItAndNoOther) {
  Executor executor;
  const auto group = executor.create_callback_group();
  std::unique_ptr<Spinning> beside;
  group->post([&] {
    beside = spin_beside(executor);
    throw std::runtime_error("broken");
  });
  EXPECT_THROW(executor.spin(), std::runtime_error);
  std::promise<void> ran;
  group->post([&ran] { ran.set_value(); });
  EXPECT_EQ(ran.get_future().wait_for(kLong), std::future_status::ready);
}

TEST(Executor, AnExceptionWithoutHandlerLeavesSpin) {
  for (const std::size_t threads : {1U, 4U}) {
    Executor executor(threads);
    const auto group = executor.create_callback_group();
    group->post([] { throw std::runtime_error("broken"); });
    EXPECT_THROW(executor.spin(), std::runtime_error) << threads;
    // The executor still works.
    group->post([&] { executor.stop(); });
    executor.spin();
  }
}

TEST(Executor, AnExceptionGoesToTheHandlerAndTheOthersGoOn) {
  Executor executor;
  const auto group = executor.create_callback_group();
  std::string told;
  group->set_exception_handler([&](std::exception_ptr error) {
    try {
      std::rethrow_exception(error);
    } catch (const std::exception& exception) {
      told = exception.what();
    }
  });
  bool next_ran = false;
  group->post([] { throw std::runtime_error("broken"); });
  group->post([&] { next_ran = true; });
  EXPECT_EQ(executor.spin_ready(), 2U);
  EXPECT_EQ(told, "broken");
  EXPECT_TRUE(next_ran);
}

TEST(Executor, WhatAHandlerThrowsLeavesSpin) {
  Executor executor;
  const auto group = executor.create_callback_group();
  group->set_exception_handler([](std::exception_ptr) { throw std::logic_error("worse"); });
  group->post([] { throw std::runtime_error("broken"); });
  EXPECT_THROW(executor.spin_until([] { return false; }, kLong), std::logic_error);
  group->post([] {});
  EXPECT_EQ(executor.spin_ready(), 1U);
}

class ExecutorThreads : public ::testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Counts, ExecutorThreads, ::testing::Values(1, 4));

TEST_P(ExecutorThreads, AnExclusiveGroupRunsOneAtATimeInOrder) {
  constexpr int kGroups = 3;
  constexpr int kEach = 500;
  Executor executor(GetParam());
  struct Stream {
    std::shared_ptr<CallbackGroup> group;
    std::atomic<int> inside{0};
    int overlaps = 0;
    std::vector<int> order;
  };
  std::vector<Stream> streams(kGroups);
  std::latch done(kGroups * kEach);
  for (auto& stream : streams) {
    stream.group = executor.create_callback_group();
  }
  {
    const Spinning spinning(executor);
    for (int i = 0; i < kEach; ++i) {
      for (auto& stream : streams) {
        stream.group->post([&stream, &done, i] {
          stream.overlaps += stream.inside.fetch_add(1) != 0 ? 1 : 0;
          stream.order.push_back(i);
          --stream.inside;
          done.count_down();
        });
      }
    }
    done.wait();
  }
  for (const auto& stream : streams) {
    EXPECT_EQ(stream.overlaps, 0);
    ASSERT_EQ(stream.order.size(), static_cast<std::size_t>(kEach));
    EXPECT_TRUE(std::is_sorted(stream.order.begin(), stream.order.end()));
  }
}

TEST_P(ExecutorThreads, ManyProducersLoseNothing) {
  constexpr int kProducers = 3;
  constexpr int kEach = 1000;
  Executor executor(GetParam());
  const auto group = executor.create_callback_group(CallbackGroupType::kReentrant);
  std::latch done(kProducers * kEach);
  const Spinning spinning(executor);
  std::vector<std::thread> producers;
  for (int p = 0; p < kProducers; ++p) {
    producers.emplace_back([&] {
      for (int i = 0; i < kEach; ++i) {
        group->post([&] { done.count_down(); });
      }
    });
  }
  for (auto& producer : producers) {
    producer.join();
  }
  done.wait();
}

TEST_P(ExecutorThreads, ManyTimersAllFireOnce) {
  constexpr int kTimers = 500;
  Executor executor(GetParam());
  const auto group = executor.create_callback_group(CallbackGroupType::kReentrant);
  std::latch done(kTimers);
  std::vector<std::atomic<int>> fired(kTimers);
  std::vector<std::shared_ptr<Work>> timers;
  const Spinning spinning(executor);
  for (int i = 0; i < kTimers; ++i) {
    timers.push_back(std::make_shared<Work>([&fired, &done, i] {
      ++fired[static_cast<std::size_t>(i)];
      done.count_down();
    }));
    group->schedule_at(steady_now() + std::chrono::microseconds(i % 7 * 300), timers.back());
  }
  done.wait();
  for (const auto& count : fired) {
    EXPECT_EQ(count, 1);
  }
}

TEST(Executor, AReentrantGroupRunsSideBySide) {
  Executor executor(2);
  const auto group = executor.create_callback_group(CallbackGroupType::kReentrant);
  std::latch both_inside(2);
  std::latch done(2);
  const Spinning spinning(executor);
  for (int i = 0; i < 2; ++i) {
    group->post([&] {
      both_inside.arrive_and_wait();
      done.count_down();
    });
  }
  done.wait();
}

TEST(Executor, GroupsRunSideBySideWhileOneIsBlocked) {
  Executor executor(2);
  const auto blocked = executor.create_callback_group();
  const auto free = executor.create_callback_group();
  std::promise<void> release;
  std::promise<void> ran;
  std::promise<void> ran_timed;
  const auto timed = std::make_shared<Work>([&] { ran_timed.set_value(); });
  const Spinning spinning(executor);
  blocked->post([&] { release.get_future().wait(); });
  // The queue of the blocked group must not hide the other's work, nor the timers.
  blocked->post([] {});
  blocked->post([] {});
  free->post([&] { ran.set_value(); });
  ran.get_future().wait();
  free->schedule_at(steady_now() + milliseconds(1), timed);
  ran_timed.get_future().wait();
  release.set_value();
}

TEST(Executor, TimersRunInTheOrderOfTheirTimes) {
  Executor executor;
  const auto group = executor.create_callback_group();
  std::vector<int> order;
  const auto first = std::make_shared<Work>([&] { order.push_back(1); });
  const auto second = std::make_shared<Work>([&] { order.push_back(2); });
  const auto third = std::make_shared<Work>([&] { order.push_back(3); });
  const SteadyTime base = steady_now();
  group->schedule_at(base + milliseconds(2), third);
  group->schedule_at(base + milliseconds(1), second);
  group->schedule_at(base - seconds(1), first);
  EXPECT_TRUE(executor.spin_until([&] { return order.size() == 3; }, kLong));
  EXPECT_THAT(order, ElementsAre(1, 2, 3));
}

TEST(Executor, SchedulingAgainReplacesTheTime) {
  Executor executor;
  const auto group = executor.create_callback_group();
  int runs = 0;
  const auto work = std::make_shared<Work>([&] { ++runs; });
  group->schedule_at(steady_now() + hours(1), work);
  group->schedule_at(steady_now() - seconds(1), work);
  EXPECT_EQ(executor.spin_ready(), 1U);
  group->schedule_at(steady_now() - seconds(1), work);
  group->schedule_at(steady_now() + hours(1), work);
  EXPECT_EQ(executor.spin_ready(), 0U);
  EXPECT_EQ(runs, 1);
}

TEST(Executor, CancelledAndDestroyedTimersDoNotRun) {
  Executor executor;
  const auto group = executor.create_callback_group();
  const auto cancelled = std::make_shared<Work>([] { FAIL(); });
  group->schedule_at(steady_now() - seconds(1), cancelled);
  group->cancel(cancelled);
  auto destroyed = std::make_shared<Work>([] { FAIL(); });
  group->schedule_at(steady_now() - seconds(1), destroyed);
  destroyed.reset();
  EXPECT_EQ(executor.spin_ready(), 0U);
}

TEST(Executor, AnEarlierTimerWakesAWaitingThread) {
  Executor executor;
  const auto group = executor.create_callback_group();
  std::promise<void> ran;
  const auto late = std::make_shared<Work>([] {});
  const auto early = std::make_shared<Work>([&] { ran.set_value(); });
  group->schedule_at(steady_now() + hours(1), late);
  const Spinning spinning(executor);
  group->schedule_at(steady_now() + milliseconds(1), early);
  EXPECT_EQ(ran.get_future().wait_for(kLong), std::future_status::ready);
}

TEST(Executor, SleepsWhileNothingIsToDo) {
  // A thread that polled would give up the processor again and again.
  Executor idle;
  const auto group = idle.create_callback_group();
  const auto late = std::make_shared<Work>([] {});
  group->schedule_at(steady_now() + hours(1), late);
  const auto switches = [&] {
    std::promise<long> counted;
    group->post([&] {
      rusage usage{};
      getrusage(RUSAGE_THREAD, &usage);
      counted.set_value(usage.ru_nvcsw);
    });
    return counted.get_future().get();
  };
  const Spinning spinning(idle);
  const long before = switches();
  Executor other;
  EXPECT_FALSE(other.spin_until([] { return false; }, milliseconds(100)));
  EXPECT_LE(switches() - before, 10);
}

TEST(CallbackGroup, AClosedGroupDropsQueuedTimedAndNewWork) {
  Executor executor;
  const auto group = executor.create_callback_group();
  const auto other = executor.create_callback_group();
  auto held = std::make_shared<int>(0);
  const std::weak_ptr<int> weak = held;
  group->post([held] { FAIL(); });
  held.reset();
  const auto timed = std::make_shared<Work>([] { FAIL(); });
  const auto kept = std::make_shared<Work>([] {});
  group->schedule_at(steady_now() - seconds(1), timed);
  other->schedule_at(steady_now() - seconds(1), kept);
  group->close();
  EXPECT_TRUE(weak.expired());
  group->post([] { FAIL(); });
  group->schedule(timed);
  group->schedule_at(steady_now() - seconds(1), timed);
  EXPECT_EQ(executor.spin_ready(), 1U);
}

TEST(CallbackGroup, AHeldGroupKeepsItsWorkUntilItIsReleased) {
  Executor executor;
  for (const auto type : {CallbackGroupType::kMutuallyExclusive, CallbackGroupType::kReentrant}) {
    const auto held = executor.create_callback_group(type);
    const auto other = executor.create_callback_group();
    std::vector<int> order;
    held->hold();
    const auto timed = std::make_shared<Work>([&order] { order.push_back(4); });
    held->schedule_at(steady_now() - seconds(1), timed);
    held->post([&order] { order.push_back(1); });
    other->post([&order] { order.push_back(2); });
    held->post([&order] { order.push_back(3); });
    EXPECT_EQ(executor.spin_ready(), 1U);
    EXPECT_THAT(order, ElementsAre(2));
    held->release();
    held->release();
    EXPECT_EQ(executor.spin_ready(), 3U);
    EXPECT_THAT(order, ElementsAre(2, 1, 3, 4));
  }
}

TEST(CallbackGroup, ReleasingWakesTheExecutor) {
  Executor executor(2);
  const auto held = executor.create_callback_group();
  held->hold();
  const Spinning spinning(executor);
  std::promise<void> ran;
  held->post([&ran] { ran.set_value(); });
  held->release();
  ran.get_future().wait();
}

TEST(CallbackGroup, AHeldGroupThatIsClosedDropsItsWork) {
  Executor executor;
  auto held = executor.create_callback_group();
  held->hold();
  auto owned = std::make_shared<int>(0);
  const std::weak_ptr<int> weak = owned;
  held->post([owned] { FAIL(); });
  owned.reset();
  held->close();
  EXPECT_TRUE(weak.expired());
  held->release();
  EXPECT_EQ(executor.spin_ready(), 0U);
}

TEST(CallbackGroup, CloseWaitsForTheRunningCallback) {
  Executor executor;
  const auto group = executor.create_callback_group();
  std::promise<void> entered;
  std::promise<void> release;
  std::atomic<bool> left = false;
  const Spinning spinning(executor);
  group->post([&] {
    entered.set_value();
    release.get_future().wait();
    left = true;
  });
  entered.get_future().wait();
  std::thread closer([&] {
    group->close();
    EXPECT_TRUE(left);
  });
  release.set_value();
  closer.join();
}

TEST(CallbackGroup, ClosesFromItsOwnCallback) {
  Executor executor;
  const auto group = executor.create_callback_group();
  int runs = 0;
  group->post([&] {
    ++runs;
    group->close();
  });
  group->post([&] { ++runs; });
  EXPECT_EQ(executor.spin_ready(), 1U);
  EXPECT_EQ(runs, 1);
}

TEST(CallbackGroup, TwoCallbacksMayCloseTheirGroupTogether) {
  Executor executor(2);
  const auto group = executor.create_callback_group(CallbackGroupType::kReentrant);
  std::latch both_inside(2);
  std::latch done(2);
  const Spinning spinning(executor);
  for (int i = 0; i < 2; ++i) {
    group->post([&] {
      both_inside.arrive_and_wait();
      group->close();
      done.count_down();
    });
  }
  done.wait();
}

TEST(CallbackGroup, TellsOnceWhenItsLastCallbackHasReturned) {
  Executor executor(2);
  const auto group = executor.create_callback_group(CallbackGroupType::kReentrant);
  EXPECT_TRUE(group->when_idle([] { FAIL(); }));
  std::latch both_inside(3);
  std::promise<void> release_first;
  std::promise<void> release_second;
  std::atomic<int> left = 0;
  std::promise<int> left_when_told;
  const Spinning spinning(executor);
  for (auto* release : {&release_first, &release_second}) {
    group->post([&, release] {
      both_inside.arrive_and_wait();
      release->get_future().wait();
      ++left;
    });
  }
  both_inside.arrive_and_wait();
  EXPECT_FALSE(group->when_idle([&] { left_when_told.set_value(left); }));
  release_first.set_value();
  release_second.set_value();
  EXPECT_EQ(left_when_told.get_future().get(), 2);
}

TEST(CallbackGroup, TellsOfItselfAfterTheCallbackThatAsks) {
  Executor executor;
  const auto group = executor.create_callback_group();
  bool returned = false;
  bool told = false;
  group->post([&] {
    EXPECT_FALSE(group->when_idle([&] {
      EXPECT_TRUE(returned);
      told = true;
    }));
    group->close();
    returned = true;
  });
  executor.spin_ready();
  EXPECT_TRUE(told);
}

TEST(CallbackGroup, OutlivesItsExecutor) {
  std::shared_ptr<CallbackGroup> group;
  auto held = std::make_shared<int>(0);
  const std::weak_ptr<int> weak = held;
  {
    Executor executor;
    group = executor.create_callback_group();
    group->post([held] {});
    held.reset();
  }
  EXPECT_TRUE(weak.expired());
  group->post([] { FAIL(); });
  group->close();
  EXPECT_EQ(group->type(), CallbackGroupType::kMutuallyExclusive);
}

TEST(CallbackGroup, AWaitableMayDropTheLastReferenceToItsGroupWhenItDies) {
  // Its destructor runs in the middle of the executor's work, and uses the executor.
  struct Closing final : Waitable {
    explicit Closing(std::shared_ptr<CallbackGroup> owned) : group(std::move(owned)) {}
    Closing(const Closing&) = delete;
    Closing& operator=(const Closing&) = delete;
    ~Closing() override { group->close(); }
    void execute() override {}
    std::shared_ptr<CallbackGroup> group;
  };
  Executor executor;
  auto group = executor.create_callback_group();
  group->schedule(std::make_shared<Closing>(group));
  group->schedule(std::make_shared<Closing>(group));
  group.reset();
  EXPECT_EQ(executor.spin_ready(), 1U);
}

}  // namespace
}  // namespace pipescout
