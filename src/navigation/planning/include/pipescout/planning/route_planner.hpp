// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "pipescout/navigation_maps/route_graph.hpp"

namespace pipescout::navigation {

/// What driving along an edge (its position in RouteGraph::edges()) costs: at least 0, finite.
using EdgeCost = std::function<double(const RouteGraph&, std::uint32_t edge)>;

/// The cost that the file gives the edge; without one, its length in m.
[[nodiscard]] EdgeCost cost_of_file();
[[nodiscard]] EdgeCost length_cost();
/// s, at the edge's speed, and at `speed` m/s (above 0) where it gives none.
[[nodiscard]] EdgeCost time_cost(double speed);

enum class RouteStatus {
  kFound,
  kNoWay,  ///< no open edges lead there
};

struct Route {
  RouteStatus status = RouteStatus::kNoWay;
  std::vector<std::uint32_t> edges;  ///< positions in RouteGraph::edges(), in the order of driving
  double cost = 0;
};

struct AlternativeLimits {
  double largest_stretch = 1.5;  ///< of the cost of the best route, [1, 100]
  double largest_share = 0.7;    ///< of its cost that a route has in common with any other, [0, 1]
};

/// Cheapest routes: A* with landmarks (Goldberg and Harrelson, "Computing the shortest path: A*
/// search meets graph theory", 2005). Bounds from the distances to a few landmarks lead the search;
/// they were computed with all edges open, so they hold whatever is closed, and a route is planned
/// anew at once when an edge has been closed or opened. The costs are those of Dijkstra's
/// algorithm.
///
/// Not thread-safe. Node and edge arguments out of range throw std::invalid_argument.
class RoutePlanner {
 public:
  /// `landmarks`: [0, 16]; 0 for Dijkstra's algorithm. O(landmarks * n log n), 8 bytes for each
  /// node and landmark. Throws std::invalid_argument for a cost that is negative or not finite.
  RoutePlanner(std::shared_ptr<const RouteGraph> graph, const EdgeCost& cost, int landmarks = 16);
  ~RoutePlanner();
  RoutePlanner(RoutePlanner&&) noexcept;
  RoutePlanner& operator=(RoutePlanner&&) noexcept;

  /// Opens edges whose `closed_until` has come, and closes the others that have one; what close()
  /// and open() said of these is forgotten. Before the first call they are all closed.
  void set_time(double time);
  void close(std::uint32_t edge);
  void open(std::uint32_t edge);
  [[nodiscard]] bool is_closed(std::uint32_t edge) const;
  /// Infinity for a closed edge.
  [[nodiscard]] double cost(std::uint32_t edge) const;

  /// A route with no edges where both nodes are the same.
  [[nodiscard]] Route find(std::uint32_t from, std::uint32_t to);
  /// The best route and up to `count` - 1 others that differ, by raising the costs of the edges of
  /// those found (Bader and others, "Alternative route graphs in road networks", 2011, penalty).
  [[nodiscard]] std::vector<Route> alternatives(std::uint32_t from, std::uint32_t to,
                                                std::size_t count,
                                                const AlternativeLimits& limits = {});
  /// Costs from a node to all others with what is open now; infinity where no way leads.
  [[nodiscard]] std::vector<double> costs_from(std::uint32_t node);
  /// Nodes that the last find() took up.
  [[nodiscard]] std::size_t expanded() const;
  [[nodiscard]] const RouteGraph& graph() const;

 private:
  class Search;
  std::unique_ptr<Search> search_;
};

}  // namespace pipescout::navigation
