// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "pipescout/odometry/weld_positioning.hpp"

namespace pipescout::odometry::test {

/// Lengths that never repeat and differ clearly.
inline std::vector<TallyJoint> fingerprint(std::size_t joints) {
  std::vector<TallyJoint> tally;
  for (std::size_t j = 0; j < joints; ++j) {
    tally.push_back({11.0 + 2.0 * std::fmod(0.618034 * static_cast<double>(j * j), 1.0), 0.01});
  }
  return tally;
}

/// A known start, to 0.05 m.
inline WeldPositioningStart at_joint(std::size_t joint, double distance,
                                     Orientation orientation = Orientation::kForward) {
  return {.joint_known = true,
          .joint = joint,
          .distance = distance,
          .distance_standard_deviation = 0.05,
          .orientation = orientation};
}

}  // namespace pipescout::odometry::test
