// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_study/drawn_maps.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

namespace pipescout::navigation_study {
namespace {

using navigation::CellState;
using navigation::OccupancyGrid;
using navigation::Pose2d;
using navigation::RouteEdge;
using navigation::RouteGraph;
using navigation::RouteNode;
using statistics::Draw;

constexpr double kResolution = 0.1;  // m
// What each kind of draw is for; worlds of one seed are independent.
enum Purpose : std::uint64_t { kRoads = 1, kField, kPlant, kMaze };

OccupancyGrid free_area(double width, double height) {
  return {{.resolution = kResolution,
           .width = static_cast<int>(std::lround(width / kResolution)),
           .height = static_cast<int>(std::lround(height / kResolution))},
          CellState::kFree};
}

/// A rectangle in m, from corner to corner.
void fill(OccupancyGrid& grid, double x, double y, double to_x, double to_y, CellState state) {
  const auto cell = [](double value) { return static_cast<int>(std::lround(value / kResolution)); };
  for (int row = cell(y); row < cell(to_y); ++row) {
    for (int column = cell(x); column < cell(to_x); ++column) {
      if (grid.contains({column, row})) {
        grid.set({column, row}, state);
      }
    }
  }
}

void join(std::vector<RouteEdge>& edges, std::uint32_t a, std::uint32_t b, double cost,
          bool both_ways) {
  const auto id = static_cast<std::int64_t>(edges.size());
  edges.push_back({.id = id, .from = a, .to = b, .cost = cost, .one_way = !both_ways});
  if (both_ways) {
    edges.push_back({.id = id + 1, .from = b, .to = a, .cost = cost});
  }
}

}  // namespace

std::shared_ptr<const RouteGraph> draw_roads(std::uint64_t seed, std::uint32_t side) {
  constexpr double kSpacing = 10;
  constexpr double kOff = 3;
  constexpr double kMissing = 0.15;
  constexpr double kOneWay = 0.05;
  Draw draw(seed, kRoads);
  std::vector<RouteNode> nodes;
  std::vector<RouteEdge> edges;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    nodes.push_back({.id = i,
                     .position = {kSpacing * (i % side) + draw.uniform(-kOff, kOff),
                                  kSpacing * (i / side) + draw.uniform(-kOff, kOff)}});
  }
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    if (!draw.happens(kMissing)) {
      const double cost = distance(nodes[a].position, nodes[b].position) * draw.uniform(1, 2);
      join(edges, a, b, cost, !draw.happens(kOneWay));
    }
  };
  for (std::uint32_t i = 0; i < side * side; ++i) {
    if (i % side + 1 < side) {
      add(i, i + 1);
    }
    if (i / side + 1 < side) {
      add(i, i + side);
    }
  }
  return std::make_shared<const RouteGraph>(std::move(nodes), std::move(edges));
}

CollectorField draw_collector_field(std::uint64_t seed) {
  constexpr double kDriven = 0.7;
  Draw draw(seed, kField);
  const auto blocks = static_cast<std::uint32_t>(2 + draw.index(3));
  const auto rows = static_cast<std::uint32_t>(4 + draw.index(7));
  const double spacing = draw.uniform(12, 25);
  CollectorField field;
  std::vector<RouteNode> nodes;
  std::vector<RouteEdge> edges;
  double x = 0;
  // A cross road before, between and after the blocks; each row joins two of them.
  for (std::uint32_t road = 0; road <= blocks; ++road) {
    for (std::uint32_t row = 0; row < rows; ++row) {
      nodes.push_back(
          {.id = static_cast<std::int64_t>(nodes.size()), .position = {x, spacing * row}});
    }
    x += draw.uniform(100, 200);
  }
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    const auto edge = static_cast<std::uint32_t>(edges.size());
    join(edges, a, b, distance(nodes[a].position, nodes[b].position), true);
    return edge;
  };
  for (std::uint32_t road = 0; road <= blocks; ++road) {
    for (std::uint32_t row = 0; row < rows; ++row) {
      const std::uint32_t node = road * rows + row;
      if (row + 1 < rows) {
        (void)add(node, node + 1);
      }
      if (road < blocks) {
        const std::uint32_t edge = add(node, node + rows);
        if (draw.happens(kDriven)) {
          field.rows.push_back(edge);
        }
      }
    }
  }
  field.graph = std::make_shared<const RouteGraph>(std::move(nodes), std::move(edges));
  return field;
}

OccupancyGrid draw_plant(std::uint64_t seed) {
  constexpr double kWidth = 300;
  constexpr double kHeight = 200;
  constexpr double kRoad = 8;
  constexpr double kCollector = 1.5;
  constexpr int kHuts = 25;
  Draw draw(seed, kPlant);
  OccupancyGrid grid = free_area(kWidth, kHeight);
  for (double y = kRoad; y < kHeight - kRoad; y += draw.uniform(6, 10)) {
    for (double x = kRoad; x < kWidth - kRoad;) {
      const double length = draw.uniform(25, 60);
      fill(grid, x, y, std::min(x + length, kWidth - kRoad), y + kCollector, CellState::kOccupied);
      x += length + draw.uniform(4, kRoad);
    }
  }
  for (int i = 0; i < kHuts; ++i) {
    const double x = draw.uniform(kRoad, kWidth - 2 * kRoad);
    const double y = draw.uniform(kRoad, kHeight - 2 * kRoad);
    fill(grid, x, y, x + draw.uniform(2, 6), y + draw.uniform(2, 6), CellState::kOccupied);
  }
  return grid;
}

OccupancyGrid draw_maze(std::uint64_t seed) {
  constexpr double kAisle = 3;
  constexpr double kWall = 0.2;
  constexpr double kPitch = kAisle + kWall;
  constexpr int kColumns = 18;
  constexpr int kRows = 12;
  constexpr double kSecondOpenings = 0.15;
  Draw draw(seed, kMaze);
  OccupancyGrid grid = free_area(kColumns * kPitch + kWall, kRows * kPitch + kWall);
  for (int i = 0; i <= kColumns; ++i) {
    fill(grid, i * kPitch, 0, i * kPitch + kWall, kRows * kPitch + kWall, CellState::kOccupied);
  }
  for (int i = 0; i <= kRows; ++i) {
    fill(grid, 0, i * kPitch, kColumns * kPitch + kWall, i * kPitch + kWall, CellState::kOccupied);
  }
  const auto open = [&](int column, int row, bool to_the_right) {
    const double x = column * kPitch;
    const double y = row * kPitch;
    if (to_the_right) {
      fill(grid, x + kPitch, y + kWall, x + kPitch + kWall, y + kPitch, CellState::kFree);
    } else {
      fill(grid, x + kWall, y + kPitch, x + kPitch, y + kPitch + kWall, CellState::kFree);
    }
  };
  // A spanning tree from random depth-first steps, then openings besides.
  std::vector<bool> visited(static_cast<std::size_t>(kColumns * kRows), false);
  std::vector<int> stack{0};
  visited[0] = true;
  while (!stack.empty()) {
    const int at = stack.back();
    std::vector<int> next;
    const int column = at % kColumns;
    const int row = at / kColumns;
    for (const auto& [other, is_there] :
         {std::pair{at + 1, column + 1 < kColumns}, std::pair{at - 1, column > 0},
          std::pair{at + kColumns, row + 1 < kRows}, std::pair{at - kColumns, row > 0}}) {
      if (is_there && !visited[static_cast<std::size_t>(other)]) {
        next.push_back(other);
      }
    }
    if (next.empty()) {
      stack.pop_back();
      continue;
    }
    const int to = next[draw.index(next.size())];
    visited[static_cast<std::size_t>(to)] = true;
    open(std::min(at, to) % kColumns, std::min(at, to) / kColumns, std::abs(at - to) == 1);
    stack.push_back(to);
  }
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      if (column + 1 < kColumns && draw.happens(kSecondOpenings)) {
        open(column, row, true);
      }
      if (row + 1 < kRows && draw.happens(kSecondOpenings)) {
        open(column, row, false);
      }
    }
  }
  return grid;
}

Pose2d draw_free_pose(Draw& draw, const OccupancyGrid& grid,
                      const navigation::Footprint& footprint) {
  while (true) {
    const navigation::Point2d position =
        transform(grid.geometry().origin, {draw.uniform(0, grid.width() * grid.resolution()),
                                           draw.uniform(0, grid.height() * grid.resolution())});
    const Pose2d pose{position.x, position.y, draw.uniform(-std::numbers::pi, std::numbers::pi)};
    if (!collides(footprint, grid, pose, navigation::UnknownCells::kBlocked)) {
      return pose;
    }
  }
}

}  // namespace pipescout::navigation_study
