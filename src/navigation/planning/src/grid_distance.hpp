// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "pipescout/navigation_maps/distance_field.hpp"

namespace pipescout::navigation {

/// Lower bounds of the length of any path to a root, for a disc that moves among obstacles: over
/// coarse cells, of which only those are closed in which the disc collides wherever it is. Computed
/// outwards from the root as far as asked (Dial, "Algorithm 360", 1969: integer costs in buckets).
class GridDistance {
 public:
  GridDistance(const OccupancyGrid& grid, const DistanceField& field, double disc_radius);

  /// The field has changed: what is known of cells is forgotten.
  void forget();
  void set_root(const Point2d& root);
  /// Goes on outwards until `position` is reached, or `should_stop`. False where it cannot be
  /// reached, which is proven, or when told to stop (`stopped` is then true).
  [[nodiscard]] bool reach(const Point2d& position, const std::function<bool()>& should_stop,
                           bool& stopped);
  /// m. Where nothing was computed yet: what has been computed so far at least.
  [[nodiscard]] double bound(const Point2d& position) const;

 private:
  [[nodiscard]] std::int64_t cell_of(const Point2d& position) const;
  [[nodiscard]] bool is_open(int column, int row);

  const OccupancyGrid& grid_;
  const DistanceField& field_;
  double disc_radius_;
  int scale_;  ///< cells of the grid per coarse cell, along each axis
  int width_;
  int height_;
  std::vector<std::int32_t> costs_;
  std::vector<std::int8_t> open_;  ///< -1: not known yet
  std::vector<std::vector<std::int64_t>> buckets_;
  std::int32_t level_ = 0;
  bool exhausted_ = false;
};

}  // namespace pipescout::navigation
