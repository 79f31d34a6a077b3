// SPDX-License-Identifier: Apache-2.0
// Turns a robot about in an aisle of 3 m and prints the path.
#include <iostream>
#include <numbers>

#include "pipescout/planning/lattice_planner.hpp"

using namespace pipescout::navigation;

int main() {
  const OccupancyGrid aisle({.resolution = 0.1, .width = 200, .height = 30}, CellState::kFree);
  const Footprint robot = Footprint::rectangle(1.0, 0.4, 0.8);  // front, rear, width in m
  LatticePlanner planner(aisle, robot, generate_primitives(1.2, 0.2));
  int questions = 5000;  // a deadline by a clock in a program of your own
  const Plan plan =
      planner.plan({5, 1.5, 0}, {12, 1.5, std::numbers::pi}, [&] { return --questions < 0; });
  std::cout << text_of(plan.status) << ": " << plan.path.length() << " m, " << plan.path.cusps()
            << " cusps, at most " << plan.suboptimality << " times the best cost\n";
  for (const PathPose& at : plan.path.poses()) {
    std::cout << at.pose.x << ' ' << at.pose.y << ' ' << at.pose.heading << ' '
              << (at.direction == Direction::kForward ? "forward" : "reverse") << '\n';
  }
}
