// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "pipescout/navigation_maps/footprint.hpp"
#include "pipescout/navigation_maps/occupancy_grid.hpp"
#include "pipescout/navigation_maps/route_graph.hpp"

namespace pipescout::navigation {

/// A graph for the overall plan over a grid for the paths between (Ibarguren and others,
/// "Thermal Tracking in Mobile Robots for Leak Inspection Activities", 2013, section 4.2).
struct HybridMap {
  RouteGraph graph;
  OccupancyGrid grid;
};

/// What keeps a robot from using a map as it stands.
struct MapProblem {
  enum class Kind {
    kNodeOutside,   ///< of the grid
    kNodeBlocked,   ///< the position of the node is not free
    kEdgeBlocked,   ///< the footprint collides on the way
    kDisconnected,  ///< no way leads there and back from the first node
  };
  Kind kind;
  std::string text;  ///< names the node or edge by its id, and where
  Point2d position;  ///< m, of it
};

/// Checks that graph and grid belong together: each edge is driven along in steps of half a cell,
/// headed along its line, by the footprint. In the order of nodes, edges, parts.
[[nodiscard]] std::vector<MapProblem> check_map(const HybridMap& map, const Footprint& footprint);

}  // namespace pipescout::navigation
