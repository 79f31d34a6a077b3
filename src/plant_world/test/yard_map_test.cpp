// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_world/yard_map.hpp"

#include <gtest/gtest.h>

namespace pipescout::simulation {
namespace {

TEST(YardMap, ShowsWhatIsMapped) {
  PlantYard yard({.people = 0, .vehicles = 0, .unmapped = 0}, 1);
  const navigation::HybridMap map = map_of(yard);
  const auto body = navigation::Footprint::rectangle(1.55, 0.35, 1.0);
  EXPECT_TRUE(check_map(map, body).empty());
  EXPECT_EQ(map.grid.at(map.grid.cell_at({20, 0}).value()), navigation::CellState::kOccupied);
  EXPECT_EQ(map.graph.opposite(0), static_cast<std::uint32_t>(yard.parameters().rows - 1));
}

}  // namespace
}  // namespace pipescout::simulation
