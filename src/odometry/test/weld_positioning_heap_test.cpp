// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "crawler_run.hpp"
#include "heap_guard.hpp"

namespace pipescout::odometry {
namespace {

TEST(WeldPositioningHeap, NothingIsAllocatedAfterConstruction) {
  test::CrawlerRunSettings settings;
  settings.double_slips = 10;
  settings.missing_joints = 5;
  settings.extra_joints = 5;
  const auto run = test::simulate_crawler_run(settings, 1001);
  for (const bool has_tally : {true, false}) {
    WeldPositioningStart start{.orientation = Orientation::kUnknown};
    if (!has_tally) {
      start = {.joint_known = true, .joint = 100, .orientation = Orientation::kForward};
    }
    WeldPositioning positioning(
        {}, has_tally ? std::span<const TallyJoint>(run.tally) : std::span<const TallyJoint>{},
        start);
    std::size_t allocations = 0;
    {
      const test::HeapGuard guard;
      for (const auto& event : run.events) {
        if (event.is_weld) {
          positioning.add_weld(event.weld);
        } else {
          positioning.add_increment(event.increment);
        }
      }
      allocations = guard.allocations();
    }
    EXPECT_EQ(allocations, 0U) << (has_tally ? "with" : "without") << " a tally";
    EXPECT_TRUE(positioning.estimate().known);
  }
}

}  // namespace
}  // namespace pipescout::odometry
