// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipescout/navigation_maps/pose2d.hpp"

namespace pipescout::navigation {

enum class CellState : std::uint8_t { kFree, kOccupied, kUnknown };

/// Column and row of a cell; column counts along the grid's x axis, row along its y axis.
struct Cell {
  int column = 0;
  int row = 0;

  bool operator==(const Cell&) const = default;
};

/// Where a grid lies and how large its cells are.
struct GridGeometry {
  double resolution = 0.1;  ///< m, edge of a cell, (0, 1000]
  Pose2d origin;            ///< T_map_grid: the outer corner of cell (0, 0), and the axes' heading
  int width = 0;            ///< columns, [1, 100000]
  int height = 0;           ///< rows, [1, 100000]

  bool operator==(const GridGeometry&) const = default;
  /// Throws std::invalid_argument that names the field.
  void validate() const;
};

/// Which cells of an area a robot can drive on. Cells are squares with their edges; rows are stored
/// one after the other, row 0 first, as nav_msgs/OccupancyGrid does. All outside is kUnknown.
class OccupancyGrid {
 public:
  /// Throws std::invalid_argument for an invalid geometry, or more than 1e9 cells.
  OccupancyGrid(const GridGeometry& geometry, CellState state);
  /// `cells` of width * height; throws std::invalid_argument for another number.
  OccupancyGrid(const GridGeometry& geometry, std::vector<CellState> cells);

  [[nodiscard]] const GridGeometry& geometry() const { return geometry_; }
  [[nodiscard]] double resolution() const { return geometry_.resolution; }
  [[nodiscard]] int width() const { return geometry_.width; }
  [[nodiscard]] int height() const { return geometry_.height; }
  [[nodiscard]] const std::vector<CellState>& cells() const { return cells_; }

  [[nodiscard]] bool contains(Cell cell) const {
    return cell.column >= 0 && cell.row >= 0 && cell.column < geometry_.width &&
           cell.row < geometry_.height;
  }
  /// kUnknown outside.
  [[nodiscard]] CellState at(Cell cell) const {
    return contains(cell) ? cells_[index(cell)] : CellState::kUnknown;
  }
  /// Throws std::invalid_argument outside.
  void set(Cell cell, CellState state);

  /// Position of a cell that the grid contains in cells().
  [[nodiscard]] std::size_t index(Cell cell) const {
    return static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(geometry_.width) +
           static_cast<std::size_t>(cell.column);
  }

  /// Position in the grid's frame, in cells: (0.5, 0.5) is the centre of cell (0, 0).
  [[nodiscard]] Point2d to_grid(const Point2d& p_map) const;
  /// Pose in the grid's frame, position in cells.
  [[nodiscard]] Pose2d to_grid(const Pose2d& T_map_robot) const;
  /// The cell at a position in the map's frame; nothing outside and for NaN.
  [[nodiscard]] std::optional<Cell> cell_at(const Point2d& p_map) const;
  /// The centre of a cell in the map's frame.
  [[nodiscard]] Point2d centre(Cell cell) const;

  bool operator==(const OccupancyGrid&) const = default;

 private:
  GridGeometry geometry_;
  double cosine_;
  double sine_;
  std::vector<CellState> cells_;
};

}  // namespace pipescout::navigation
