// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "heap_guard.hpp"
#include "pipescout/odometry/weld_detector.hpp"
#include "weld_signal.hpp"

namespace pipescout::odometry {
namespace {

TEST(WeldDetectorHeap, NothingIsAllocatedAfterConstruction) {
  for (const std::size_t channels : {1U, 4U}) {
    for (const bool again : {false, true}) {
      WeldDetector detector({.channels = channels, .report_again = again});
      const auto welds = test::welds_at({10.0, 22.0, 34.0, 46.0});
      std::mt19937_64 engine(1);
      std::normal_distribution<double> noise(0.0, 0.1);
      std::size_t events = 0;
      std::size_t allocations = 0;
      {
        const pipescout::test::HeapGuard guard;
        std::array<Impedance, 4> values{};
        for (int i = 0; i < 100000; ++i) {
          // There and back, with stops, gaps, jumps and bad values on the way.
          double at = 50.0 - std::abs(50.0 - 0.001 * i);
          at += i > 20000 && i < 25000 ? 3.0 : 0.0;
          at += i == 30000 ? 1000.0 : 0.0;
          at += i > 90000 ? -1e5 : 0.0;
          const auto value = welds(at);
          for (auto& one : values) {
            one = {value.real() + noise(engine), value.imag() + noise(engine)};
          }
          values[0].x = i % 1000 == 0 ? std::numeric_limits<double>::quiet_NaN() : values[0].x;
          values[0].x += i % 1700 == 0 ? 9.0 : 0.0;
          events += detector.update(at, std::span(values).first(channels)).size();
        }
        events += detector.finish().size();
        allocations = guard.allocations();
      }
      EXPECT_EQ(allocations, 0U);
      EXPECT_GE(events, 3U);
      EXPECT_GT(detector.counts().jumps, 0U);
      EXPECT_GT(detector.counts().spikes, 0U);
    }
  }
}

}  // namespace
}  // namespace pipescout::odometry
