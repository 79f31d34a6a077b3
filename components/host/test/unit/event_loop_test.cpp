// SPDX-License-Identifier: Apache-2.0
#include "run/event_loop.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <thread>

namespace pipescout::host {
namespace {

SteadyTime soon() {
  return SteadyTime(std::chrono::steady_clock::now()) + std::chrono::minutes(1);
}

TEST(EventLoop, RunsPostedWorkOfOtherThreads) {
  EventLoop loop;
  int done = 0;
  std::thread other([&] {
    for (int i = 0; i < 100; ++i) {
      loop.post([&] { ++done; });
    }
  });
  EXPECT_TRUE(loop.run_until([&] { return done == 100; }, soon()));
  other.join();
}

TEST(EventLoop, CallsForReadableDescriptors) {
  EventLoop loop;
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  bool closed = false;
  std::string text;
  loop.watch(ends[0], [&] {
    std::array<char, 8> bytes{};
    const auto size = read(ends[0], bytes.data(), bytes.size());
    if (size > 0) {
      text.append(bytes.data(), static_cast<std::size_t>(size));
    } else {
      closed = true;
      loop.unwatch(ends[0]);
    }
  });
  ASSERT_EQ(write(ends[1], "abc", 3), 3);
  EXPECT_TRUE(loop.run_until([&] { return text == "abc"; }, soon()));
  close(ends[1]);
  EXPECT_TRUE(loop.run_until([&] { return closed; }, soon()));
  close(ends[0]);
}

TEST(EventLoop, WakesForTurnsAndDeadlines) {
  EventLoop loop;
  int turns = 0;
  loop.on_turn([&](SteadyTime now) -> std::optional<SteadyTime> {
    ++turns;
    return now + std::chrono::milliseconds(1);
  });
  EXPECT_TRUE(loop.run_until([&] { return turns >= 5; }, soon()));
  EXPECT_FALSE(loop.run_until([] { return false; }, SteadyTime(std::chrono::steady_clock::now())));
}

}  // namespace
}  // namespace pipescout::host
