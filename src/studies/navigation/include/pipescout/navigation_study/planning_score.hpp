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

/// Time, and the work that is done in it: other programs on the machine take time as well.
struct PlanningClocks {
  Clock time;
  Clock work;  ///< s, of the processor for this thread
};

/// One query of a lattice planner.
struct PathSample {
  navigation::PlanStatus status = navigation::PlanStatus::kNotFound;
  double first = 0;  ///< s, to the first path
  double total = 0;  ///< s
  /// s of work, from when the planner last asked before the deadline until it answered; 0 if it was
  /// done before.
  double overrun = 0;
  double length = 0;         ///< m
  double suboptimality = 1;  ///< the bound that the planner states
  bool curvature_kept = true;
  bool goal_met = true;  ///< within 1 mm and 0.001 rad
  bool free = true;      ///< each pose checked against the grid
};

/// Plans shortest paths (nothing but length costs) between the poses until `deadline` s.
[[nodiscard]] PathSample score_path(navigation::LatticePlanner& planner, const StudyRobot& robot,
                                    const navigation::Pose2d& start, const navigation::Pose2d& goal,
                                    double deadline, const PlanningClocks& clocks);

/// A path that an obstacle came to stand on, planned anew.
struct ReplanSample {
  bool first_found = false;  ///< else nothing was planned anew
  double first = 0;          ///< s, of the plan before, to its first path
  double again = 0;          ///< s, to enter the obstacle and to plan around it
  bool found = false;
  bool free = true;  ///< each pose of the new path checked against the grid
};

/// Plans until `deadline` s, puts an obstacle of 0.5 x 0.5 m onto the middle third of the path, and
/// replans from where the robot was, within as long. The obstacle is removed afterwards.
[[nodiscard]] ReplanSample score_replan(navigation::LatticePlanner& planner,
                                        const StudyRobot& robot, const navigation::Pose2d& start,
                                        const navigation::Pose2d& goal, double deadline,
                                        statistics::Draw& draw, const Clock& clock);

/// A planner for shortest paths of that robot.
[[nodiscard]] navigation::LatticePlanner shortest_path_planner(
    const navigation::OccupancyGrid& grid, const StudyRobot& robot);

/// Cost of a tour over its lower bound, in the drawn field of the seed; 0 for a tour that leaves
/// out a row.
[[nodiscard]] double score_tour(std::uint64_t seed);

}  // namespace pipescout::navigation_study
