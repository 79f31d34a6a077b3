// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "heap_guard.hpp"
#include "pipescout/simulation/thermal_patrol.hpp"

namespace pipescout::simulation {
namespace {

TEST(ThermalHeap, FramesTakeNothing) {
  ThermalPatrolParameters parameters;
  parameters.scene.leaks = {{.place = 4, .length = 1}};
  for (const auto kind : {ThermalDecoyKind::kBrightJoint, ThermalDecoyKind::kPassingReflection,
                          ThermalDecoyKind::kHotPixels, ThermalDecoyKind::kWarmSupport,
                          ThermalDecoyKind::kSunGlint, ThermalDecoyKind::kHotBody}) {
    parameters.scene.decoys.push_back({.kind = kind, .place = 5, .size = 1});
  }
  ThermalPatrol patrol(parameters);
  patrol.drive_until(5);
  ThermalTruth truth;
  patrol.renderer().truth(patrol.view(0), truth);
  ASSERT_FALSE(truth.leaks.empty());
  std::vector<std::uint16_t> counts(320 * 240);
  const pipescout::test::HeapGuard guard;
  for (std::uint64_t frame = 0; frame < 10; ++frame) {
    for (int step = 0; step < 20; ++step) {
      patrol.step();
    }
    patrol.render(frame, counts);
    patrol.renderer().truth(patrol.view(frame), truth);
  }
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
}  // namespace pipescout::simulation
