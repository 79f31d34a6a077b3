// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipescout/navigation_maps/pose2d.hpp"

namespace pipescout::navigation {

/// On which side of an edge, seen in its direction, a pipe stands.
enum class PipeSide : std::uint8_t { kNone, kLeft, kRight, kBoth };

struct RouteNode {
  std::int64_t id = 0;  ///< unique among nodes
  Point2d position;     ///< m
  std::string frame = "map";
};

/// A way that can be driven from one node to another, and in no other direction: a road in both
/// directions is two edges.
struct RouteEdge {
  std::int64_t id = 0;     ///< of the file; see RouteGraph
  std::uint32_t from = 0;  ///< position of the node in RouteGraph::nodes()
  std::uint32_t to = 0;
  std::optional<double> cost;   ///< as the file gives it, at least 0; without: the length
  std::optional<double> speed;  ///< m/s, largest, above 0
  std::optional<double> width;  ///< m, above 0
  PipeSide pipe_side = PipeSide::kNone;
  bool one_way = false;                ///< no edge leads back
  std::optional<double> closed_until;  ///< s, time of the plant; infinity: until further notice
  std::vector<Point2d> line;           ///< from node to node, both included; empty: straight
};

/// The roads of a plant. Immutable: what is closed for a while is the planner's business.
class RouteGraph {
 public:
  RouteGraph() = default;
  /// Throws std::invalid_argument naming the node or edge by its id: nodes of one id, edges of one
  /// id between different places, ends that are not there, an edge from a node to itself, frames
  /// that differ, values outside their ranges, coordinates that are not finite. Edges of one id
  /// between the same places are allowed: Nav2's depot has them, where two nodes lie on each other.
  RouteGraph(std::vector<RouteNode> nodes, std::vector<RouteEdge> edges);

  [[nodiscard]] const std::vector<RouteNode>& nodes() const { return nodes_; }
  [[nodiscard]] const std::vector<RouteEdge>& edges() const { return edges_; }
  /// Positions in edges().
  [[nodiscard]] std::span<const std::uint32_t> outgoing(std::uint32_t node) const {
    return {outgoing_.data() + first_[node], outgoing_.data() + first_[node + 1]};
  }
  /// m, along the line.
  [[nodiscard]] double length(std::uint32_t edge) const { return lengths_[edge]; }
  /// Positions of a node or an edge; nothing for an id that is not there, or that two have. O(log
  /// n).
  [[nodiscard]] std::optional<std::uint32_t> node_of_id(std::int64_t id) const;
  [[nodiscard]] std::optional<std::uint32_t> edge_of_id(std::int64_t id) const;
  /// The edge back to where `edge` comes from; nothing if there is none.
  [[nodiscard]] std::optional<std::uint32_t> opposite(std::uint32_t edge) const;
  /// Nothing for an empty graph or a position that is not finite. O(n).
  [[nodiscard]] std::optional<std::uint32_t> nearest_node(const Point2d& position) const;
  /// Of each node: the number of its strongly connected part, by the order of their first nodes
  /// (Tarjan, "Depth-first search and linear graph algorithms", 1972).
  [[nodiscard]] std::vector<std::uint32_t> strong_parts() const;

 private:
  using Index = std::vector<std::pair<std::int64_t, std::uint32_t>>;  ///< sorted

  std::vector<RouteNode> nodes_;
  std::vector<RouteEdge> edges_;
  std::vector<double> lengths_;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> outgoing_;
  Index node_ids_;
  Index edge_ids_;
};

}  // namespace pipescout::navigation
