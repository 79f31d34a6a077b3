// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/navigation_maps/footprint.hpp"
#include "pipescout/navigation_maps/occupancy_grid.hpp"

namespace pipescout::navigation {

/// Cells from `low` to `high`, both included.
struct CellBox {
  Cell low;
  Cell high;
};

/// How far the centre of each cell is from the nearest blocked cell: from the square, not from its
/// centre. Exact up to a largest distance, so that a change of the grid changes the field only
/// nearby (after Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", 2012:
/// one pass per axis). What is outside the grid counts as unknown.
class DistanceField {
 public:
  /// `largest` m: [resolution, 100], at most 200 cells; throws std::invalid_argument.
  DistanceField(const OccupancyGrid& grid, UnknownCells unknown, double largest);

  /// m, at most largest(); 0 in a blocked cell. Of a cell outside: 0 where unknown blocks, else
  /// largest().
  [[nodiscard]] double at(Cell cell) const;
  /// Bounds of the distance of a position in the frame of the grid, in cells, from the nearest
  /// blocked square, m. The high one holds only below largest().
  struct Bounds {
    double low;
    double high;
  };
  [[nodiscard]] Bounds bounds(const Point2d& p_grid) const;
  [[nodiscard]] double largest() const { return largest_; }
  /// Cells of `grid`, of the same geometry, have changed in `box`: computes what that can change.
  /// Throws std::invalid_argument for another geometry.
  void update(const OccupancyGrid& grid, const CellBox& box);

 private:
  void compute(const OccupancyGrid& grid, const CellBox& box);

  GridGeometry geometry_;
  UnknownCells unknown_;
  double largest_;
  int reach_;                 ///< cells
  std::vector<float> cells_;  ///< distances in cells
};

}  // namespace pipescout::navigation
