// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "../src/step_reporter.hpp"
#include "pipescout/runtime/activity.hpp"
#include "pipescout/runtime/executor.hpp"

namespace pipescout {
namespace {

using ::testing::ElementsAre;

// A thread that is held up between counting and telling must not tell after one that counted later:
// the simulation would wait for messages that have arrived.
TEST(QuiescenceWatch, TellsCountsInTheirOrder) {
  const auto activity = std::make_shared<Activity>();
  const auto traffic = std::make_shared<StepTraffic>();
  Executor executor;
  const Gid writer{{1}};
  std::vector<std::int64_t> told;
  std::promise<void> counted;
  std::promise<void> go_on;
  bool is_first = true;
  const auto watch = QuiescenceWatch::create(
      activity, traffic, executor.create_callback_group(CallbackGroupType::kMutuallyExclusive),
      [&](const StepTraffic::Counts& counts, std::uint64_t) {
        if (std::exchange(is_first, false)) {
          counted.set_value();
          go_on.get_future().wait();
        }
        told.push_back(counts.received.at(writer));
      });
  traffic->received({.writer = writer, .sequence_number = 1});
  std::thread held_up([&] { watch->request(); });
  counted.get_future().wait();
  traffic->received({.writer = writer, .sequence_number = 2});
  auto later = std::async(std::launch::async, [&] { watch->request(); });
  // It waits for the other one; this only gives a fault the time to show.
  later.wait_for(std::chrono::milliseconds(50));
  go_on.set_value();
  held_up.join();
  later.get();
  EXPECT_THAT(told, ElementsAre(1, 2));
}

}  // namespace
}  // namespace pipescout
