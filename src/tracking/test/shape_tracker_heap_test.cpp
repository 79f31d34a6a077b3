// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "heap_guard.hpp"
#include "tracked_pictures.hpp"

namespace pipescout::tracking {
namespace {

TEST(ShapeTracker, TakesNothingFromTheHeapAfterConstruction) {
  test::Pictures pictures;
  std::vector<std::vector<PipeRegion>> shown;
  for (int i = 0; i < 100; ++i) {
    std::vector<PipeRegion> regions;
    for (int k = 0; k < 30 && i % 20 < 15; ++k) {
      regions.push_back(test::region_of({100 + 7.0 * k, 100 + 3.0 * i + 4 * k, 60.0 + k, 0.3}));
    }
    shown.push_back(regions);
  }
  const pipescout::test::HeapGuard guard;
  for (const auto& regions : shown) {
    pictures.show(regions);
  }
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
}  // namespace pipescout::tracking
