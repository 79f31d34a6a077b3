// SPDX-License-Identifier: Apache-2.0
#include "playback_clock.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace pipescout {
namespace {

using namespace std::chrono_literals;

constexpr Time kStart{1000s};
constexpr SteadyTime kNow{50s};

TEST(PlaybackClockTest, BeginsPaused) {
  const PlaybackClock clock(kStart);
  EXPECT_TRUE(clock.paused());
  EXPECT_EQ(clock.time(kNow), kStart);
  EXPECT_EQ(clock.when(kStart + 1s, kNow), SteadyTime::max());
}

TEST(PlaybackClockTest, RunsAtItsRate) {
  PlaybackClock clock(kStart, 2.0);
  clock.resume(kNow);
  EXPECT_EQ(clock.time(kNow + 3s), kStart + 6s);
  EXPECT_EQ(clock.when(kStart + 6s, kNow), kNow + 3s);
  EXPECT_EQ(clock.when(kStart + 6s, kNow + 10s), kNow + 10s);
  clock.set_rate(0.5, kNow + 3s);
  EXPECT_EQ(clock.time(kNow + 5s), kStart + 7s);
}

TEST(PlaybackClockTest, StandsWhilePaused) {
  PlaybackClock clock(kStart);
  clock.resume(kNow);
  clock.pause(kNow + 2s);
  EXPECT_EQ(clock.time(kNow + 9s), kStart + 2s);
  clock.resume(kNow + 10s);
  clock.resume(kNow + 11s);  // changes nothing
  EXPECT_EQ(clock.time(kNow + 12s), kStart + 4s);
}

TEST(PlaybackClockTest, CanBeginLater) {
  PlaybackClock clock(kStart);
  clock.resume(kNow + 5s);
  EXPECT_EQ(clock.time(kNow + 1s), kStart);
  EXPECT_EQ(clock.when(kStart, kNow), kNow + 5s);
  clock.set_rate(2.0, kNow + 1s);
  EXPECT_EQ(clock.time(kNow + 6s), kStart + 2s);
}

TEST(PlaybackClockTest, CanBeSet) {
  PlaybackClock clock(kStart);
  clock.resume(kNow);
  clock.set(kStart + 100s, kNow + 1s);
  EXPECT_EQ(clock.time(kNow + 2s), kStart + 101s);
}

}  // namespace
}  // namespace pipescout
