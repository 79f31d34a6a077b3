// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "pipescout/navigation_maps/distance_field.hpp"

namespace pipescout::navigation {

/// Lower bounds of the length of any path to a root, for a disc that moves among obstacles.
///
/// Coarse cells are closed if the disc does not fit into them. Distances are those
/// of steps along the sides (10) and diagonals (14) of open cells, between the corners of cells.
/// docs/decisions/lower-bound-by-a-lipschitz-function.md proves that, over sqrt(1 + 0.4^2), they
/// bound the length of each curve through open cells.
///
/// A* from the root to where the robot stands, in integer buckets (Hart, Nilsson and Raphael, 1968;
/// Dial, "Algorithm 360", 1969), and on for detours of some size: what is farther off the way is
/// bounded without having been visited.
class GridDistance {
 public:
  /// What a coarse cell is closed for.
  enum class Use {
    kProof,  ///< the disc collides wherever in it its centre is: bounds hold
    kGuide   ///< it collides at the centre of each of the grid's cells in it: more of what is too
             ///< narrow is closed, and little that is not
  };
  GridDistance(const OccupancyGrid& grid, const DistanceField& field, double disc_radius, Use use);

  /// The field has changed in the box: what is known of cells there is forgotten.
  void forget(const CellBox& box);
  void set_root(const Point2d& root, const Point2d& robot);
  /// False where the robot cannot reach the root, for proofs proven, or when told to stop
  /// (`stopped` is then true).
  [[nodiscard]] bool reach(const std::function<bool()>& should_stop, bool& stopped);
  /// m, of the length of a path from a position to the root.
  [[nodiscard]] double bound(const Point2d& position) const {
    return bound_in_grid(grid_.to_grid(position));
  }
  /// The same for a position in the frame of the grid, in cells.
  [[nodiscard]] double bound_in_grid(const Point2d& p_grid) const;

 private:
  struct Corner {
    int x;
    int y;
  };
  struct Reached {
    std::int32_t cost;
    std::uint32_t query;  ///< the cost is of this one
  };

  [[nodiscard]] std::size_t index(Corner corner) const {
    return static_cast<std::size_t>(corner.y) * static_cast<std::size_t>(columns_ + 1) +
           static_cast<std::size_t>(corner.x);
  }
  [[nodiscard]] Corner nearest(const Point2d& p_grid) const;
  [[nodiscard]] std::int8_t& state_of_cell(int column, int row);
  [[nodiscard]] bool is_open(int column, int row);
  void step(Corner from, int x, int y, std::int32_t cost);
  void take_up(Corner corner);

  const OccupancyGrid& grid_;
  const DistanceField& field_;
  double disc_radius_;
  double needed_;  ///< m, distance of the centre of a cell that is open
  int scale_;      ///< cells of the grid per coarse cell, along each axis
  double cell_;    ///< m
  int columns_;
  int rows_;
  std::vector<std::int8_t> open_;  ///< with a closed border; -1: not known yet
  std::vector<Reached> reached_;   ///< of each corner of a coarse cell
  std::vector<std::vector<Corner>> buckets_;
  std::uint32_t query_ = 0;
  std::int32_t level_ = 0;  ///< of cost and estimate: what is below is settled
  Corner root_{0, 0};
  Corner robot_{0, 0};
  double root_off_ = 0;  ///< m, of the root from its corner
};

}  // namespace pipescout::navigation
