// SPDX-License-Identifier: Apache-2.0
#include "core/size_window.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>

namespace pipescout::host {
namespace {

using std::chrono::milliseconds;

TEST(SizeWindow, CountsBytesPerSecond) {
  SizeWindow window(3);
  const SteadyTime start{};
  EXPECT_FALSE(window.statistics(start));
  window.arrived(start, 1'000'000);  // leaves the window
  window.arrived(start + milliseconds(500), 100);
  window.arrived(start + milliseconds(1000), 300);
  window.arrived(start + milliseconds(1500), 200);
  const auto statistics = window.statistics(start + milliseconds(2500));
  ASSERT_TRUE(statistics);
  EXPECT_DOUBLE_EQ(statistics->bytes_per_second, 300.0);
  EXPECT_EQ(to_string(*statistics),
            "300.00 B/s from 3 messages\n"
            "\tMessage size mean: 200.00 B min: 100.00 B max: 300.00 B");
}

TEST(SizeWindow, ChoosesTheUnitByTheRate) {
  EXPECT_EQ(to_string(SizeWindow::Statistics{2.5e6, 1e5, 90'000, 110'000, 25}),
            "2.50 MB/s from 25 messages\n\tMessage size mean: 0.10 MB min: 0.09 MB max: 0.11 MB");
  EXPECT_EQ(to_string(SizeWindow::Statistics{1500.0, 15.0, 15, 15, 100}),
            "1.50 KB/s from 100 messages\n\tMessage size mean: 0.01 KB min: 0.01 KB max: 0.01 KB");
}

TEST(DelayWindow, TellsHowLateMessagesAre) {
  DelayWindow window(2);
  EXPECT_FALSE(window.statistics());
  window.arrived(milliseconds(9000));  // leaves the window
  window.arrived(milliseconds(10));
  window.arrived(milliseconds(30));
  const auto statistics = window.statistics();
  ASSERT_TRUE(statistics);
  EXPECT_EQ(to_string(*statistics),
            "average delay: 0.020\n\tmin: 0.010s max: 0.030s std dev: 0.01000s window: 2");
}

TEST(Windows, HoldAtLeastOneMessage) {
  EXPECT_THROW(SizeWindow(0), std::invalid_argument);
  EXPECT_THROW(DelayWindow(0), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::host
