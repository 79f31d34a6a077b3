// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <stdexcept>
#include <thread>
#include <vector>

#include "call_gate.hpp"
#include "event_thread.hpp"

namespace pipescout::dds {
namespace {

TEST(EventThreadTest, RunsEventsInTheirOrder) {
  EventThread events;
  std::vector<int> seen;
  events.admit(&seen);
  std::latch done(1);
  for (int i = 0; i < 100; ++i) {
    events.post(&seen, [&seen, i] { seen.push_back(i); });
  }
  events.post(&seen, [&done] { done.count_down(); });
  done.wait();
  ASSERT_EQ(seen.size(), 100U);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(seen[static_cast<std::size_t>(i)], i);
  }
}

TEST(EventThreadTest, DismissingWaitsForTheEventInProgress) {
  EventThread events;
  const int owner = 0;
  events.admit(&owner);
  std::latch entered(1);
  std::latch go_on(1);
  std::atomic<bool> finished{false};
  events.post(&owner, [&] {
    entered.count_down();
    go_on.wait();
    finished = true;
  });
  entered.wait();
  std::thread helper([&] { go_on.count_down(); });
  events.dismiss(&owner);
  EXPECT_TRUE(finished);
  helper.join();
}

TEST(EventThreadTest, DismissingDropsWhatIsPendingOfItsOwnerOnly) {
  EventThread events;
  const int owner = 0;
  events.admit(&owner);
  const int other = 0;
  events.admit(&other);
  std::latch go_on(1);
  std::latch other_ran(1);
  std::atomic<bool> dropped_ran{false};
  events.post(&other, [&] { go_on.wait(); });
  events.post(&owner, [&] { dropped_ran = true; });
  events.post(&other, [&] { other_ran.count_down(); });
  events.dismiss(&owner);
  go_on.count_down();
  other_ran.wait();
  EXPECT_FALSE(dropped_ran);
}

TEST(EventThreadTest, TakesNothingFromAnOwnerThatIsNotAdmitted) {
  EventThread events;
  const int owner = 0;
  events.admit(&owner);
  const int stranger = 0;
  std::latch done(1);
  std::atomic<bool> stranger_ran{false};
  events.post(&stranger, [&] { stranger_ran = true; });
  events.post(&owner, [&] { done.count_down(); });
  done.wait();
  EXPECT_FALSE(stranger_ran);
}

TEST(EventThreadTest, AnEventMayDismissItsOwner) {
  EventThread events;
  const int owner = 0;
  events.admit(&owner);
  std::latch done(1);
  events.post(&owner, [&] {
    events.dismiss(&owner);
    done.count_down();
  });
  done.wait();
}

TEST(EventThreadTest, AnExceptionEndsItsEventOnly) {
  EventThread events;
  const int owner = 0;
  events.admit(&owner);
  std::latch done(1);
  events.post(&owner, [] { throw std::runtime_error("from the test, on purpose"); });
  events.post(&owner, [&] { done.count_down(); });
  done.wait();
}

TEST(CallGateTest, LetsCallsThroughUntilItIsClosed) {
  CallGate gate;
  {
    const CallGate::Pass first(gate);
    const CallGate::Pass second(gate);
    EXPECT_TRUE(first);
    EXPECT_TRUE(second);
  }
  gate.close();
  EXPECT_FALSE(CallGate::Pass(gate));
}

TEST(CallGateTest, ClosingWaitsForCallsInProgress) {
  constexpr int kThreads = 3;
  for (int round = 0; round < 50; ++round) {
    CallGate gate;
    int guarded = 0;  // written after the closing, so a call that slips through is a data race
    std::latch started(kThreads);
    std::vector<std::thread> callers;
    for (int i = 0; i < kThreads; ++i) {
      callers.emplace_back([&] {
        started.count_down();
        for (;;) {
          const CallGate::Pass pass(gate);
          if (!pass) {
            return;
          }
          EXPECT_EQ(*static_cast<volatile int*>(&guarded), 0);
        }
      });
    }
    started.wait();
    gate.close();
    guarded = 1;
    for (std::thread& caller : callers) {
      caller.join();
    }
  }
}

}  // namespace
}  // namespace pipescout::dds
