// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "pipescout/navigation_study/drawn_maps.hpp"
#include "pipescout/planning/lattice_planner.hpp"

namespace pipescout::navigation_study {

/// s, from any instant on: the studies read no clock themselves.
using Clock = std::function<double()>;

/// The robot of the studies: 1.4 x 0.8 m, origin at the rear axle, turning radius 1.2 m.
struct StudyRobot {
  navigation::Footprint footprint = navigation::Footprint::rectangle(1.0, 0.4, 0.8);
  double turning_radius = 1.2;  ///< m
  double spacing = 0.2;         ///< m, of the lattice
};

/// One query of a lattice planner.
struct PathSample {
  navigation::PlanStatus status = navigation::PlanStatus::kNotFound;
  double first = 0;          ///< s, to the first path
  double total = 0;          ///< s
  double length = 0;         ///< m
  double suboptimality = 1;  ///< the bound that the planner states
  bool curvature_kept = true;
  bool goal_met = true;  ///< within 1 mm and 0.001 rad
  bool free = true;      ///< each pose checked against the grid
};

/// Plans shortest paths (nothing but length costs) between the poses until `deadline` s.
[[nodiscard]] PathSample score_path(navigation::LatticePlanner& planner, const StudyRobot& robot,
                                    const navigation::Pose2d& start, const navigation::Pose2d& goal,
                                    double deadline, const Clock& clock);

/// A planner for shortest paths of that robot.
[[nodiscard]] navigation::LatticePlanner shortest_path_planner(
    const navigation::OccupancyGrid& grid, const StudyRobot& robot);

/// Cost of a tour over its lower bound, in the drawn field of the seed; 0 for a tour that leaves
/// out a row.
[[nodiscard]] double score_tour(std::uint64_t seed);

}  // namespace pipescout::navigation_study
