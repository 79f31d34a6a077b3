// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "figures.hpp"
#include "pipescout/navigation_maps/occupancy_grid.hpp"

namespace pipescout::benchmarks {

struct PathCases {
  int queries = 10;
  double deadline = 0.150;     ///< s, ours
  double peer_deadline = 1.5;  ///< s, at which the peers must have found a path to succeed
  double peer_seconds = 10;    ///< after which their best path is compared; at least peer_deadline
  std::uint64_t seed = 1;
};

/// The lattice planner compared with OMPL's RRT* and BIT* on the same queries: share found, time to
/// the first path, length. Figures are named `lattice_..._NAME`.
void compare_paths(Figures& figures, const std::string& name, const navigation::OccupancyGrid& grid,
                   const PathCases& cases);

}  // namespace pipescout::benchmarks
