// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "arc_list.hpp"
#include "pipescout/navigation_maps/distance_field.hpp"
#include "pipescout/planning/lattice_planner.hpp"

namespace pipescout::navigation {

/// Moves a footprint over a grid. Discs that cover it decide by the distance field where there is
/// room; elsewhere the footprint itself is checked.
class FootprintSweep {
 public:
  FootprintSweep(OccupancyGrid grid, Footprint footprint, const LatticeSettings& settings);

  [[nodiscard]] const OccupancyGrid& grid() const { return grid_; }
  [[nodiscard]] const DistanceField& field() const { return field_; }
  [[nodiscard]] double inscribed_radius() const { return footprint_.inscribed_radius(); }
  void change(std::span<const CellChange> cells);

  [[nodiscard]] bool is_free(const Pose2d& pose) const { return room(pose) > 0; }
  [[nodiscard]] bool is_free(const Pose2d& start, const ArcList& arcs) const;
  /// m of the arcs that are free from the start on.
  [[nodiscard]] double free_length(const Pose2d& start, const ArcList& arcs) const;
  /// Integral along the arcs of how near obstacles are: 0 from `near` on, 1 at contact; m.
  [[nodiscard]] double nearness(const Pose2d& start, const ArcList& arcs) const;

 private:
  struct Disc {
    Point2d centre;
  };

  /// 0 if the footprint collides; else m that it can be driven on before it is checked again: along
  /// what the discs leave free, by one step where there is room for a corner to swing out in it,
  /// and by next to nothing where there is not.
  [[nodiscard]] double room(const Pose2d& pose) const;

  OccupancyGrid grid_;
  Footprint footprint_;
  Footprint with_swing_;  ///< enlarged by what a corner swings out within a step
  std::vector<Disc> discs_;
  double disc_radius_ = 0;
  double step_;
  double near_;
  UnknownCells unknown_;
  DistanceField field_;
};

}  // namespace pipescout::navigation
