// SPDX-License-Identifier: Apache-2.0
#include "emulated_links.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pipescout_test {
namespace {

using namespace std::chrono_literals;
using Time = EmulatedLinks::Time;

constexpr std::size_t kFrameBytes = 1250;  // 10 ms at 1 Mbit/s

EmulatedLinks::Frame frame(int number, std::size_t bytes = kFrameBytes) {
  return EmulatedLinks::Frame(bytes, static_cast<std::uint8_t>(number));
}

/// What arrives by and by: the time of the step at which it does, the direction, the first byte.
struct Arrival {
  Time time;
  std::size_t direction;
  int number;
  bool operator==(const Arrival&) const = default;
};

std::vector<Arrival> all_arrivals(EmulatedLinks& links) {
  std::vector<Arrival> arrivals;
  while (const auto next = links.next()) {
    links.advance(*next, [&](std::size_t direction, const EmulatedLinks::Frame& arrived) {
      arrivals.push_back({*next, direction, arrived.at(0)});
    });
  }
  return arrivals;
}

TEST(EmulatedLinksTest, DelayAndRateAddUp) {
  EmulatedLinks links({.delay = 20ms, .rate = 1e6}, 1);
  links.send(0, frame(1), 0, 100ms);
  links.send(0, frame(2), 0, 100ms);
  links.send(0, frame(3), 0, 200ms);
  EXPECT_EQ(all_arrivals(links),
            (std::vector<Arrival>{{130ms, 0, 1}, {140ms, 0, 2}, {230ms, 0, 3}}));
}

TEST(EmulatedLinksTest, TheHeaderTakesNoTime) {
  EmulatedLinks links({.rate = 1e6}, 1);
  links.send(0, frame(1, kFrameBytes + 10), 10, 0ms);
  EXPECT_EQ(all_arrivals(links), (std::vector<Arrival>{{10ms, 0, 1}}));
}

TEST(EmulatedLinksTest, WithoutRateAllArriveAtOnce) {
  EmulatedLinks links({.delay = 5ms}, 2);
  links.send(0, frame(1), 0, 0ms);
  links.send(1, frame(2), 0, 0ms);
  EXPECT_EQ(all_arrivals(links), (std::vector<Arrival>{{5ms, 0, 1}, {5ms, 1, 2}}));
}

TEST(EmulatedLinksTest, EachDirectionHasTheRateUnlessItIsShared) {
  for (const bool shared : {false, true}) {
    EmulatedLinks links({.rate = 1e6, .shared = shared}, 2);
    for (const int number : {1, 2}) {
      links.send(0, frame(number), 0, 0ms);
    }
    for (const int number : {3, 4}) {
      links.send(1, frame(number), 0, 0ms);
    }
    const std::vector<Arrival> apart{{10ms, 0, 1}, {10ms, 1, 3}, {20ms, 0, 2}, {20ms, 1, 4}};
    const std::vector<Arrival> in_turns{{10ms, 0, 1}, {20ms, 1, 3}, {30ms, 0, 2}, {40ms, 1, 4}};
    EXPECT_EQ(all_arrivals(links), shared ? in_turns : apart) << shared;
  }
}

TEST(EmulatedLinksTest, AFullQueueDropsWhatComes) {
  EmulatedLinks links({.rate = 1e6}, 1);  // holds ten full Ethernet frames, and one that is sent
  for (int number = 0; number < 100; ++number) {
    links.send(0, frame(number, 1514), 0, 0ms);
  }
  const std::vector<Arrival> arrivals = all_arrivals(links);
  ASSERT_EQ(arrivals.size(), 11U);
  EXPECT_EQ(arrivals.back().number, 10);
}

TEST(EmulatedLinksTest, LosesTheShareThatIsAskedFor) {
  constexpr int kFrames = 20'000;
  EmulatedLinks links({.loss = 0.05, .delay = 1ms, .seed = 17}, 1);
  int arrived = 0;
  for (int number = 0; number < kFrames; ++number) {
    links.send(0, frame(0, 60), 0, Time{number});
  }
  arrived = static_cast<int>(all_arrivals(links).size());
  // Four standard deviations of a binomial distribution: 123.
  EXPECT_NEAR(arrived, 0.95 * kFrames, 123);
}

TEST(EmulatedLinksTest, ALateStepDoesNotSlowTheChannel) {
  EmulatedLinks links({.rate = 1e6}, 1);
  for (const int number : {1, 2, 3}) {
    links.send(0, frame(number), 0, 0ms);
  }
  std::vector<int> numbers;
  links.advance(30ms, [&](std::size_t, const EmulatedLinks::Frame& arrived) {
    numbers.push_back(arrived.at(0));
  });
  EXPECT_EQ(numbers, (std::vector<int>{1, 2, 3}));
}

}  // namespace
}  // namespace pipescout_test
