// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace pipescout::navigation {

/// Of the local planner. Defaults are for a robot of the size of the RobuCAR TT's model here: wheel
/// base 1.2 m, turning radius 2.2 m. Chosen values say what for.
struct DrivingParameters {
  // The vehicle as it is told; origin in the middle of the rear axle.
  double period = 0.05;           ///< s, [0.005, 0.1]: of the control cycle
  double wheel_base = 1.2;        ///< m, [0.1, 10]
  double largest_steering = 0.5;  ///< rad, (0, 1.4]
  double steering_rate = 0.6;     ///< rad/s, (0, 10]
  double delay = 0.1;             ///< s, [0, 0.5]: until a command acts
  double largest_speed = 2.0;     ///< m/s, (0, 10]: forwards
  double reverse_speed = 1.0;     ///< m/s, (0, 10]
  double acceleration = 0.8;      ///< m/s^2, (0, 10]
  double braking = 1.2;           ///< m/s^2, (0, 10]: what may be counted on
  double hardest_braking = 2.5;   ///< m/s^2, [braking, 10]: when `braking` would be too late
  double gentle_braking = 0.5;    ///< m/s^2, (0, 10]: before curves, cusps and the goal, for pauses
  double lateral_acceleration = 0.8;  ///< m/s^2, (0, 10]: in curves
  double creep_speed = 0.12;          ///< m/s, (0, 1]: the last way to a cusp or the goal

  // Path following.
  double convergence_length = 1.0;  ///< m, (0, 20]: lateral errors decay over it
  /// s, [0, 10]: or over so long a time, if that is more: faster than the wheels turn it weaves.
  double convergence_time = 1.0;
  double damping = 1.0;        ///< [0.3, 3]
  double largest_error = 1.0;  ///< m, (0, 10]: farther off the path it stops

  // Obstacles.
  double margin = 0.2;          ///< m, [0, 2]: around the footprint
  double hysteresis = 0.1;      ///< m, [0, 1]: more of it before the lateral offset is changed
  double stop_gap = 0.4;        ///< m, [0, 5]: it stops so far before an obstacle
  double slow_zone = 0.35;      ///< m, [0, 5]: with less beside it, it drives at slow_speed at most
  double slow_speed = 0.6;      ///< m/s, (0, 10]
  double horizon = 8;           ///< m, [2, 30]: how far ahead the motion is predicted
  double largest_offset = 1.8;  ///< m, [0, 10]: how far it leaves the path for an obstacle
  double growth = 0.2;          ///< m/s, [0, 2]: of the margin of what moves, per time predicted
  /// s, [3, 60]: farther ahead nobody knows where something that moves will be, and it counts no
  /// more. Far longer than it takes to stop.
  double foresight = 5;
  /// m, [0, 2]: instead of a larger margin, where it stood before something for wait_time that does
  /// not move and could be passed so; it is then passed at tight_speed.
  double tight_margin = 0.08;
  double tight_speed = 0.3;     ///< m/s, (0, 10]
  double wait_time = 4;         ///< s, [0, 600]: before what blocks the path, before it backs up
  double back_up_length = 1.5;  ///< m, [0, 10]

  // Inputs.
  double localisation_stale_after = 0.3;  ///< s, (0, 10]
  double scan_stale_after = 0.4;          ///< s, (0, 10]
  double largest_sigma = 0.5;             ///< m, (0, 10]: of the position
  double largest_heading_sigma = 0.1;     ///< rad, (0, 1]
  int frozen_scans = 5;  ///< [2, 1000]: equal ones, after which the lidar is frozen
  /// Occupied cells within the horizon; with more it stands, since it cannot look at all of them.
  /// In [1, 100000].
  std::size_t most_obstacle_cells = 2000;

  // Goal.
  double goal_distance = 0.1;     ///< m, (0, 5]
  double goal_heading = 0.05236;  ///< rad, (0, 1]: 3 degrees
  int goal_attempts = 3;          ///< [1, 10]

  /// Throws std::invalid_argument that names the field.
  void validate() const;
};

}  // namespace pipescout::navigation
