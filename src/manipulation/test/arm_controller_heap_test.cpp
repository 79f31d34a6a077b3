// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "arm_bench.hpp"
#include "heap_guard.hpp"

namespace pipescout::manipulation {
namespace {

TEST(ArmControllerHeap, TrackingSearchingAndStowingTakeNothing) {
  test::ArmBench bench;
  bench.cycles(1);
  std::size_t stowed = 0;
  const pipescout::test::HeapGuard guard;
  for (int i = 0; i < 3000; ++i) {
    bench.roll_rate = i % 200 < 100 ? 0.1 : -0.1;
    bench.track = i < 500 ? TrackState::kLocked : TrackState::kLost;
    stowed += bench.cycle().state == ArmState::kStowed ? 1 : 0;
  }
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_GT(stowed, 0U);
}

}  // namespace
}  // namespace pipescout::manipulation
