// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/hybrid_map.hpp"

#include <algorithm>
#include <cmath>
#include <locale>
#include <optional>
#include <sstream>

namespace pipescout::navigation {
namespace {

std::string place(const Point2d& position) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << " at (" << position.x << ", " << position.y << ") m";
  return text.str();
}

/// Where the footprint first collides on a straight line; nothing where it does not.
std::optional<Point2d> blocked_at(const Point2d& from, const Point2d& to, const HybridMap& map,
                                  const Footprint& footprint) {
  const double length = distance(from, to);
  const double heading = std::atan2(to.y - from.y, to.x - from.x);
  const double steps = std::max(1.0, std::ceil(2 * length / map.grid.resolution()));
  for (double i = 0; i <= steps; ++i) {
    const Pose2d pose{std::lerp(from.x, to.x, i / steps), std::lerp(from.y, to.y, i / steps),
                      heading};
    if (collides(footprint, map.grid, pose, UnknownCells::kBlocked)) {
      return pose.position();
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<MapProblem> check_map(const HybridMap& map, const Footprint& footprint) {
  std::vector<MapProblem> problems;
  for (const RouteNode& node : map.graph.nodes()) {
    const std::string name = "node " + std::to_string(node.id) + place(node.position);
    const auto cell = map.grid.cell_at(node.position);
    if (!cell) {
      problems.push_back(
          {MapProblem::Kind::kNodeOutside, name + " is outside the grid", node.position});
    } else if (map.grid.at(*cell) != CellState::kFree) {
      problems.push_back(
          {MapProblem::Kind::kNodeBlocked,
           name + (map.grid.at(*cell) == CellState::kOccupied ? " is in an obstacle"
                                                              : " is in an unknown area"),
           node.position});
    }
  }
  for (const RouteEdge& edge : map.graph.edges()) {
    std::vector<Point2d> line = edge.line;
    if (line.empty()) {
      line = {map.graph.nodes()[edge.from].position, map.graph.nodes()[edge.to].position};
    }
    for (std::size_t i = 1; i < line.size(); ++i) {
      if (const auto at = blocked_at(line[i - 1], line[i], map, footprint)) {
        problems.push_back({MapProblem::Kind::kEdgeBlocked,
                            "edge " + std::to_string(edge.id) + ": the robot collides" + place(*at),
                            *at});
        break;
      }
    }
  }
  const auto parts = map.graph.strong_parts();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i] != parts.front()) {
      problems.push_back({MapProblem::Kind::kDisconnected,
                          "node " + std::to_string(map.graph.nodes()[i].id) +
                              " cannot be reached from node " +
                              std::to_string(map.graph.nodes().front().id) + " and left again",
                          map.graph.nodes()[i].position});
    }
  }
  return problems;
}

}  // namespace pipescout::navigation
