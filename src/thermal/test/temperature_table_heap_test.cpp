// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "camera_helpers.hpp"
#include "heap_guard.hpp"
#include "pipescout/thermal/temperature_table.hpp"

namespace pipescout::thermal {
namespace {

TEST(TemperatureTableHeap, APictureTakesNothing) {
  const std::array<Region, 1> regions = {Region{10, 10, 20, 20, ibarguren2013_object()}};
  const RegionTables tables(test::sc660(), {}, regions);
  const TemperatureTable table(Radiometry(test::sc660(), {}));
  const std::vector<std::uint16_t> counts(64 * 48, 20000);
  std::vector<float> degrees(counts.size());
  const CountView view{counts.data(), 64, 48, 64};
  const pipescout::test::HeapGuard guard;
  table.convert(view, degrees);
  tables.convert(view, degrees);
  (void)table.first_at_least(100);
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
}  // namespace pipescout::thermal
