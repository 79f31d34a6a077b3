// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_world/yard_map.hpp"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace pipescout::simulation {
namespace {

using navigation::CellState;
using navigation::OccupancyGrid;
using navigation::RouteEdge;
using navigation::RouteNode;

constexpr double kCell = 0.1;    // m
constexpr double kBorder = 0.5;  // m, beyond the wall

void fill_box(OccupancyGrid& grid, const YardBox& box) {
  const double step = kCell / 2;
  for (double u = -box.half_length; u <= box.half_length; u += step) {
    for (double v = -box.half_width; v <= box.half_width; v += step) {
      const double x = box.centre.x() + u * std::cos(box.heading) - v * std::sin(box.heading);
      const double y = box.centre.y() + u * std::sin(box.heading) + v * std::cos(box.heading);
      if (const auto cell = grid.cell_at({x, y})) {
        grid.set(*cell, CellState::kOccupied);
      }
    }
  }
}

}  // namespace

navigation::HybridMap map_of(const PlantYard& yard) {
  const auto& p = yard.parameters();
  const double pitch = p.aisle + p.row_width;
  const double low_x = -p.road - kBorder;
  const double low_y = -p.row_width / 2 - p.road - kBorder;
  const double high_x = p.row_length + p.road + kBorder;
  const double high_y = (p.rows - 1) * pitch + p.row_width / 2 + p.road + kBorder;
  OccupancyGrid grid({.resolution = kCell,
                      .origin = {low_x, low_y, 0},
                      .width = static_cast<int>(std::ceil((high_x - low_x) / kCell)),
                      .height = static_cast<int>(std::ceil((high_y - low_y) / kCell))},
                     CellState::kFree);
  for (const YardBox& box : yard.mapped()) {
    fill_box(grid, box);
  }
  // For each aisle: on the road in the west, at both ends of the rows, on the road in the east.
  const auto aisles = static_cast<std::uint32_t>(p.rows - 1);
  std::vector<RouteNode> nodes;
  for (const double x : {-p.road / 2, 0.0, p.row_length, p.row_length + p.road / 2}) {
    for (std::uint32_t i = 0; i < aisles; ++i) {
      nodes.push_back({.id = static_cast<std::int64_t>(nodes.size()),
                       .position = {x, yard.aisle_middle(static_cast<int>(i))}});
    }
  }
  std::vector<RouteEdge> edges;
  const auto add = [&](std::uint32_t from, std::uint32_t to, navigation::PipeSide side) {
    RouteEdge edge;
    edge.id = static_cast<std::int64_t>(edges.size());
    edge.from = from;
    edge.to = to;
    edge.pipe_side = side;
    edges.push_back(edge);
  };
  const std::uint32_t east = 2 * aisles;
  for (std::uint32_t i = 0; i < aisles; ++i) {
    add(aisles + i, east + i, navigation::PipeSide::kBoth);
  }
  for (std::uint32_t i = 0; i < aisles; ++i) {
    add(east + i, aisles + i, navigation::PipeSide::kBoth);
  }
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    add(a, b, navigation::PipeSide::kNone);
    add(b, a, navigation::PipeSide::kNone);
  };
  for (std::uint32_t i = 0; i < aisles; ++i) {
    join(i, aisles + i);
    join(east + i, east + aisles + i);
  }
  for (const std::uint32_t first : {0U, east + aisles}) {
    for (std::uint32_t i = 0; i + 1 < aisles; ++i) {
      join(first + i, first + i + 1);
    }
  }
  return {navigation::RouteGraph(std::move(nodes), std::move(edges)), std::move(grid)};
}

}  // namespace pipescout::simulation
