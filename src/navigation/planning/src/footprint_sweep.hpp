// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "arc_list.hpp"
#include "pipescout/navigation_maps/distance_field.hpp"
#include "pipescout/planning/lattice_planner.hpp"

namespace pipescout::navigation {

/// Moves a footprint over a grid. Discs that cover it decide by the distance field where there is
/// room; elsewhere what the footprint itself sweeps over is checked.
class FootprintSweep {
 public:
  FootprintSweep(OccupancyGrid grid, Footprint footprint, const LatticeSettings& settings);

  [[nodiscard]] const OccupancyGrid& grid() const { return grid_; }
  [[nodiscard]] const DistanceField& field() const { return field_; }
  [[nodiscard]] double inscribed_radius() const { return footprint_.inscribed_radius(); }
  /// Returns the box that was changed.
  CellBox change(std::span<const CellChange> cells);

  /// Paths stay in the grid, also where what is unknown does not block.
  [[nodiscard]] bool is_free(const Pose2d& pose) const;
  /// Whether the footprint is free at each of the infinitely many poses.
  [[nodiscard]] bool is_free(const Pose2d& start, const ArcList& arcs) const;
  /// m of the arcs that are free from the start on; may fall short by a stretch.
  [[nodiscard]] double free_length(const Pose2d& start, const ArcList& arcs) const;
  /// Integral along the arcs of how near obstacles are: 0 from `near` on, 1 at contact; m.
  [[nodiscard]] double nearness(const Pose2d& start, const ArcList& arcs) const;

 private:
  /// m by which every point of the footprint can be moved as the discs say; may be negative.
  [[nodiscard]] double room(const Pose2d& pose) const;
  /// Part of an arc that begins at `start`, between two lengths.
  [[nodiscard]] bool is_stretch_free(const Pose2d& start, const ArcPiece& arc, double from,
                                     double to) const;
  [[nodiscard]] bool collides_at(const Pose2d& pose) const;

  OccupancyGrid grid_;
  Footprint footprint_;
  std::vector<Point2d> discs_;  ///< their centres
  double disc_radius_ = 0;
  double near_;
  UnknownCells unknown_;
  DistanceField field_;
};

}  // namespace pipescout::navigation
