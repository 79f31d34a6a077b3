// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "pipescout/navigation_maps/footprint.hpp"
#include "pipescout/navigation_maps/occupancy_grid.hpp"
#include "pipescout/navigation_maps/route_graph.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::navigation_study {

/// Roads between `side` x `side` crossings 10 m apart, each off by up to 3 m: 15 % of the roads are
/// missing, 5 % are one way, and a metre costs 1 to 2.
[[nodiscard]] std::shared_ptr<const navigation::RouteGraph> draw_roads(std::uint64_t seed,
                                                                       std::uint32_t side);

/// Rows of collectors between cross roads, and which edges are rows.
struct CollectorField {
  std::shared_ptr<const navigation::RouteGraph> graph;
  std::vector<std::uint32_t> rows;
};
/// 2 to 4 blocks of 4 to 10 rows each, 100 to 200 m long, 12 to 25 m apart; a share of the rows is
/// to be driven along.
[[nodiscard]] CollectorField draw_collector_field(std::uint64_t seed);

/// A plant of 300 x 200 m at 0.1 m: rows of collectors with gaps, cross roads, huts and tanks.
[[nodiscard]] navigation::OccupancyGrid draw_plant(std::uint64_t seed);

/// A maze of aisles 3 m wide with walls of 0.2 m, 60 x 40 m at 0.1 m; some walls have second
/// openings.
[[nodiscard]] navigation::OccupancyGrid draw_maze(std::uint64_t seed);

/// A pose in which the footprint is free, of any position and heading. Nothing is returned before
/// one is found: the grid must have room.
[[nodiscard]] navigation::Pose2d draw_free_pose(statistics::Draw& draw,
                                                const navigation::OccupancyGrid& grid,
                                                const navigation::Footprint& footprint);

}  // namespace pipescout::navigation_study
