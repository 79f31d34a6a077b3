// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "pipescout/navigation_maps/footprint.hpp"
#include "pipescout/navigation_maps/occupancy_grid.hpp"

namespace pipescout::benchmarks {

/// The peers of the lattice planner: RRT* and BIT* of the Open Motion Planning Library over
/// Reeds-Shepp paths, which minimise the length. Poses are checked by a distance field where that
/// can tell, and else by the exact check that our own planner uses, every 0.05 m.
class OmplPaths {
 public:
  enum class Algorithm { kRrtStar, kBitStar };

  OmplPaths(const navigation::OccupancyGrid& grid, navigation::Footprint footprint,
            double turning_radius);
  ~OmplPaths();

  struct Result {
    double first = 0;   ///< s, to the first path; infinity if there is none
    double length = 0;  ///< m, of the last path; infinity if there is none
  };
  /// Goes on for `seconds`.
  [[nodiscard]] Result plan(Algorithm algorithm, const navigation::Pose2d& start,
                            const navigation::Pose2d& goal, double seconds, std::uint32_t seed);

 private:
  class Checker;
  std::unique_ptr<Checker> checker_;
};

}  // namespace pipescout::benchmarks
