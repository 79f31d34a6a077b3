// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "reproduce.hpp"

namespace pipescout::reproduce {

std::span<const ReproducibleTable> reproducible_tables() {
  static constexpr std::array kTables{
      ReproducibleTable{"odometry",
                        "Table 1 of Wang and others (2008): consensus fusion of three odometers",
                        false, reproduce_odometry},
      ReproducibleTable{"in-pipe",
                        "Figures of odometry, weld detection, positioning and alignment in a pipe",
                        true, reproduce_in_pipe},
      ReproducibleTable{"rack",
                        "Table I and the figures of Lippiello and Cacace: a UAV over a pipe rack",
                        true, reproduce_rack, kRackParts},
      ReproducibleTable{"estimator",
                        "Figures of the state estimator on three robots and on real recordings",
                        true, reproduce_estimator},
      ReproducibleTable{"leaks",
                        "Figure 7 of Ibarguren and others, and the figures of leak inspection",
                        true, reproduce_leaks},
      ReproducibleTable{"tracking",
                        "Table 1 of Ibarguren and others: tracking of a pipe, and the camera arm",
                        true, reproduce_tracking},
      ReproducibleTable{"navigation",
                        "Figures of routes, tours, paths and missions in drawn plants and mazes",
                        true, reproduce_navigation},
  };
  return kTables;
}

}  // namespace pipescout::reproduce
