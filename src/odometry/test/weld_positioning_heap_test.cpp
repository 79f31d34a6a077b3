// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>
#include <span>
#include <vector>

#include "heap_guard.hpp"
#include "pipescout/odometry/weld_positioning.hpp"

namespace pipescout::odometry {
namespace {

TEST(WeldPositioningHeap, NothingIsAllocatedAfterConstruction) {
  std::mt19937_64 engine(1001);
  std::normal_distribution<double> length(12.0, 0.12);
  std::vector<TallyJoint> tally(1000);
  for (TallyJoint& joint : tally) {
    joint.length = length(engine);
  }
  for (const bool has_tally : {true, false}) {
    WeldPositioningStart start{.orientation = Orientation::kUnknown};
    if (!has_tally) {
      start = {.joint_known = true, .joint = 100, .orientation = Orientation::kForward};
    }
    WeldPositioning positioning(
        {}, has_tally ? std::span<const TallyJoint>(tally) : std::span<const TallyJoint>{}, start);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const pipescout::test::HeapGuard guard;
    for (std::size_t joint = 100; joint < 900; ++joint) {
      // Slips, joints that the tally has too many or too few, missed and spurious welds.
      const double slip = joint % 40 == 0 ? 0.5 : 0.0;
      if (joint % 150 == 0) {
        ++joint;
      }
      for (int i = 0; i < 24; ++i) {
        positioning.add_increment(
            {.distance = (tally[joint].length - slip) / 24.0, .variance = 1e-6});
        if (uniform(engine) < 0.002) {
          positioning.add_weld(
              {.odometer_distance = positioning.odometer_distance(), .standard_deviation = 0.01});
        }
      }
      if (uniform(engine) > 0.02) {
        positioning.add_weld(
            {.odometer_distance = positioning.odometer_distance(), .standard_deviation = 0.01});
      }
    }
    EXPECT_EQ(guard.allocations(), 0U) << (has_tally ? "with" : "without") << " a tally";
    EXPECT_TRUE(positioning.estimate().known);
    EXPECT_GT(positioning.counts().double_slips, 0U);
  }
}

}  // namespace
}  // namespace pipescout::odometry
