// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/navigation_maps/hybrid_map.hpp"
#include "pipescout/simulation/plant_yard.hpp"

namespace pipescout::simulation {

/// What a map shows of a yard: the mapped boxes as a grid of 0.1 m; aisles and roads as a graph.
/// With n aisles, edge i leads along aisle i from its west end to its east end, and edge n + i
/// back, both with pipes on both sides. Edges 2 n + 4 i to 2 n + 4 i + 3 join these ends to the
/// roads; then come those along the road in the west, two for each pair of neighbours, and those in
/// the east.
[[nodiscard]] navigation::HybridMap map_of(const PlantYard& yard);

}  // namespace pipescout::simulation
