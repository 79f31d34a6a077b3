// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "pipescout/manipulation/arm_controller.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::manipulation {

void ArmControllerParameters::validate(std::size_t joints) const {
  using validation::check_above;
  using validation::check_within;
  check_within("period", period, 0.001, 0.1);
  for (const auto& [name, posture] : {std::pair("ready", &ready), std::pair("stow", &stow)}) {
    if (posture->size() != joints) {
      throw std::invalid_argument(std::string(name) + ": " + std::to_string(posture->size()) +
                                  " angles for " + std::to_string(joints) + " joints");
    }
  }
  check_above("move_speed", move_speed, 0, 10);
  check_above("rotation_gain", rotation_gain, 0, 50);
  check_above("position_gain", position_gain, 0, 50);
  check_above("correction_rate", correction_rate, 0, 10);
  check_within("image_time", image_time, 0, 5);
  check_within("response_time", response_time, period, 0.5);
  check_above("largest_acceleration", largest_acceleration, 0, 200);
  check_within("damping", damping, 0, 1);
  check_above("least_manipulability", least_manipulability, 0, 1);
  check_above("rotation_weight", rotation_weight, 0, 100);
  check_above("nearest", nearest, 0, 1000);
  check_within("farthest", farthest, nearest, 1000);
  check_within("usual_range", usual_range, nearest, farthest);
  check_within("reach", reach, 0, 2);
  check_within("turn", turn, 0, 1.5);
  check_above("edge_share", edge_share, 0, 0.49);
  check_above("centred_share", centred_share, 0, 0.5 - edge_share);
  check_above("joints_stale_after", joints_stale_after, 0, 10);
  check_above("track_stale_after", track_stale_after, 0, 10);
  check_above("odometry_stale_after", odometry_stale_after, 0, 10);
  check_within("future_tolerance", future_tolerance, 0, 1);
  check_within("hold_time", hold_time, 0, 3600);
  check_within("search_time", search_time, 0, 3600);
  check_within("search_period", search_period, 0.5, 60);
  check_above("search_amplitude", search_amplitude, 0, 1.5);
  check_within("least_clearance", least_clearance, 0, 1);
  check_within("ground", ground, -10, 10);
  check_above("largest_following_error", largest_following_error, 0, 3);
}

}  // namespace pipescout::manipulation
