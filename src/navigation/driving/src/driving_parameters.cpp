// SPDX-License-Identifier: Apache-2.0
#include "pipescout/driving/driving_parameters.hpp"

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {

void DrivingParameters::validate() const {
  using validation::check_above;
  using validation::check_within;
  check_within("period", period, 0.005, 0.1);
  check_within("wheel_base", wheel_base, 0.1, 10);
  check_above("largest_steering", largest_steering, 0, 1.4);
  check_above("steering_rate", steering_rate, 0, 10);
  check_within("delay", delay, 0, 0.5);
  check_above("largest_speed", largest_speed, 0, 10);
  check_above("reverse_speed", reverse_speed, 0, 10);
  check_above("acceleration", acceleration, 0, 10);
  check_above("braking", braking, 0, 10);
  check_within("hardest_braking", hardest_braking, braking, 10);
  check_above("gentle_braking", gentle_braking, 0, 10);
  check_above("lateral_acceleration", lateral_acceleration, 0, 10);
  check_above("creep_speed", creep_speed, 0, 1);
  check_above("convergence_length", convergence_length, 0, 20);
  check_within("convergence_time", convergence_time, 0, 10);
  check_within("damping", damping, 0.3, 3);
  check_above("largest_error", largest_error, 0, 10);
  check_within("margin", margin, 0, 2);
  check_within("hysteresis", hysteresis, 0, 1);
  check_within("stop_gap", stop_gap, 0, 5);
  check_within("slow_zone", slow_zone, 0, 5);
  check_above("slow_speed", slow_speed, 0, 10);
  check_within("horizon", horizon, 2, 30);
  check_within("largest_offset", largest_offset, 0, 10);
  check_within("growth", growth, 0, 2);
  check_within("foresight", foresight, 3, 60);
  check_within("tight_margin", tight_margin, 0, 2);
  check_above("tight_speed", tight_speed, 0, 10);
  check_within("wait_time", wait_time, 0, 600);
  check_within("back_up_length", back_up_length, 0, 10);
  check_above("localisation_stale_after", localisation_stale_after, 0, 10);
  check_above("scan_stale_after", scan_stale_after, 0, 10);
  check_above("largest_sigma", largest_sigma, 0, 10);
  check_above("largest_heading_sigma", largest_heading_sigma, 0, 1);
  check_within("frozen_scans", frozen_scans, 2, 1000);
  check_within("most_obstacle_cells", static_cast<double>(most_obstacle_cells), 1, 100000);
  check_above("goal_distance", goal_distance, 0, 5);
  check_above("goal_heading", goal_heading, 0, 1);
  check_within("goal_attempts", goal_attempts, 1, 10);
}

}  // namespace pipescout::navigation
