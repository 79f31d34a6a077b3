// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "drive_helpers.hpp"
#include "heap_guard.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"

namespace pipescout::leak_findings {
namespace {

using test::Drive;

TEST(LeakFindingsHeap, FollowingTakesNothing) {
  Drive world;
  world.spots = {{10, 0.3, 90}, {11, 0.4, 120}};
  LeakFindings findings(Drive::parameters(), Drive::camera());
  std::size_t allocations = 0;
  std::size_t leaks = 0;
  for (int i = 0; i < 90; ++i) {
    const double x = 9 + 0.03 * i;
    const Frame frame = world.frame(0.04 * i, x);
    const thermal::Detections detections = world.look(x);
    const pipescout::test::HeapGuard guard;
    findings.update(frame, detections);
    if (i > 10) {
      allocations += guard.allocations();
      leaks += detections.leaks.size();
    }
  }
  EXPECT_EQ(findings.findings().size(), 2U);
  EXPECT_GT(leaks, 100U);
  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace pipescout::leak_findings
