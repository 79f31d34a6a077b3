// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "pipescout/navigation_maps/route_graph.hpp"

namespace pipescout::benchmarks {

/// The peer of routes: Dijkstra's algorithm of the Boost Graph Library on a compressed sparse row
/// graph, which ends once the goal is reached.
class BoostRoutes {
 public:
  /// With the costs of the file.
  explicit BoostRoutes(const navigation::RouteGraph& graph);
  ~BoostRoutes();
  /// The cost of the cheapest route; infinity where no way leads.
  [[nodiscard]] double cost(std::uint32_t from, std::uint32_t to);

 private:
  class Graph;
  std::unique_ptr<Graph> graph_;
};

}  // namespace pipescout::benchmarks
