// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/occupancy_grid.hpp"

#include <cmath>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kLargestResolution = 1000;  // m
constexpr int kLargestSide = 100'000;
constexpr double kLargestCount = 1e9;
constexpr double kLargestCoordinate = 1e7;  // m; half the circumference of the Earth and less

std::size_t cell_count(const GridGeometry& geometry) {
  geometry.validate();
  return static_cast<std::size_t>(geometry.width) * static_cast<std::size_t>(geometry.height);
}

}  // namespace

void GridGeometry::validate() const {
  validation::check_above("resolution", resolution, 0, kLargestResolution);
  validation::check_within("origin.x", origin.x, -kLargestCoordinate, kLargestCoordinate);
  validation::check_within("origin.y", origin.y, -kLargestCoordinate, kLargestCoordinate);
  validation::require("origin.heading", origin.heading, true, "the finite numbers");
  validation::check_within("width", width, 1, kLargestSide);
  validation::check_within("height", height, 1, kLargestSide);
  validation::check_within("width * height", static_cast<double>(width) * height, 1, kLargestCount);
}

OccupancyGrid::OccupancyGrid(const GridGeometry& geometry, CellState state)
    : OccupancyGrid(geometry, std::vector<CellState>(cell_count(geometry), state)) {}

OccupancyGrid::OccupancyGrid(const GridGeometry& geometry, std::vector<CellState> cells)
    : geometry_(geometry),
      cosine_(std::cos(geometry.origin.heading)),
      sine_(std::sin(geometry.origin.heading)),
      cells_(std::move(cells)) {
  if (cells_.size() != cell_count(geometry_)) {
    validation::refuse("cells: ", cells_.size(), " given for a grid of ", geometry_.width, " x ",
                       geometry_.height);
  }
}

void OccupancyGrid::set(Cell cell, CellState state) {
  if (!contains(cell)) {
    validation::refuse("cell: (", cell.column, ", ", cell.row, ") is outside a grid of ",
                       geometry_.width, " x ", geometry_.height);
  }
  cells_[index(cell)] = state;
}

Point2d OccupancyGrid::to_grid(const Point2d& p_map) const {
  const double x = p_map.x - geometry_.origin.x;
  const double y = p_map.y - geometry_.origin.y;
  return {(cosine_ * x + sine_ * y) / geometry_.resolution,
          (cosine_ * y - sine_ * x) / geometry_.resolution};
}

Pose2d OccupancyGrid::to_grid(const Pose2d& T_map_robot) const {
  const Point2d position = to_grid(T_map_robot.position());
  return {position.x, position.y, T_map_robot.heading - geometry_.origin.heading};
}

std::optional<Cell> OccupancyGrid::cell_at(const Point2d& p_map) const {
  const Point2d p = to_grid(p_map);
  if (!(p.x >= 0 && p.y >= 0 && p.x < geometry_.width && p.y < geometry_.height)) {
    return std::nullopt;
  }
  return Cell{static_cast<int>(p.x), static_cast<int>(p.y)};
}

Point2d OccupancyGrid::centre(Cell cell) const {
  constexpr double kHalf = 0.5;
  return transform(geometry_.origin, {(cell.column + kHalf) * geometry_.resolution,
                                      (cell.row + kHalf) * geometry_.resolution});
}

}  // namespace pipescout::navigation
