// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipescout/move_base/navigation_goal.hpp"
#include "pipescout/navigation_maps/pose2d.hpp"
#include "pipescout/navigation_study/planning_score.hpp"

/// The whole of navigation in a closed loop with a simulated vehicle: a drawn plant with a lidar,
/// people and vehicles that move, things that no map shows, and a localisation with errors.
namespace pipescout::navigation_study {

struct MissionSettings {
  double time_limit = 600;       ///< s, simulated
  double position_sigma = 0.02;  ///< m, of the localisation, correlated over 20 s
  double heading_sigma = 0.005;  ///< rad, likewise
  std::size_t questions = 3000;  ///< readings of the planner's clock in a second of its time
  double planning_delay = 0.2;   ///< s, simulated, from a request to its plan
  bool tour = false;             ///< along all aisles, with a camera, instead of to a pose
  double exposure = 0.01;        ///< s, of the camera
};

struct MissionScore {
  bool reached = false;
  navigation::NavigationFailure failure = navigation::NavigationFailure::kNone;
  std::string text;               ///< more of the failure, or what it did when time was up
  std::size_t collisions = 0;     ///< steps of 1 ms in which the vehicle overlaps anything
  double least_clearance = 0;     ///< m
  double goal_distance = 0;       ///< m, of the true pose from the goal
  double goal_heading = 0;        ///< rad
  double gap = 0;                 ///< s, the longest between two commands, computing included
  double cycle_time = 0;          ///< s, the longest of a control cycle by the given clock
  double typical_cycle_time = 0;  ///< s, median
  double time = 0;                ///< s, simulated
  double driven = 0;              ///< m
  int replans = 0;
  // Of tours.
  double pipe_metres = 0;   ///< m of rows in the goal
  double seen_percent = 0;  ///< of them, sharp by the true motion
  double speed = 0;         ///< m/s, mean while alongside a pipe
};

/// One step of a mission, for pictures.
struct MissionTrace {
  double time = 0;  ///< s
  navigation::Pose2d pose;
  double speed = 0;
  std::string state;
  std::string reason;
};

/// Drives in the plant of the seed from a drawn pose to another. `clock` in s measures the control
/// cycles. `trace`: filled at 5 Hz unless null.
[[nodiscard]] MissionScore run_mission(const MissionSettings& settings, std::uint64_t seed,
                                       const Clock& clock,
                                       std::vector<MissionTrace>* trace = nullptr);

}  // namespace pipescout::navigation_study
