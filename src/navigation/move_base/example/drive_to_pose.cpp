// SPDX-License-Identifier: Apache-2.0
// Drives a robot that follows its commands exactly across an empty yard, and prints its way.
#include <iostream>
#include <vector>

#include "pipescout/move_base/global_planner.hpp"
#include "pipescout/move_base/move_base.hpp"

using namespace pipescout::navigation;

int main() {
  const OccupancyGrid yard({.resolution = 0.1, .width = 300, .height = 200}, CellState::kFree);
  const Footprint robot = Footprint::rectangle(1.55, 0.35, 1.0);  // front, rear, width in m
  GlobalPlanner planner({RouteGraph(), yard}, robot, {});
  double readings = 0;  // a clock in a program of your own
  const auto clock = [&] { return readings += 1e-4; };
  MoveBase base({}, robot);
  base.start(PoseGoal{{25, 15, 1.57}});

  Pose2d pose{3, 3, 0};
  double speed = 0;
  std::vector<float> ranges(360);
  for (int i = 1; i < 2000; ++i) {
    const double now = 0.05 * i;
    base.add(Localisation{.time = now, .pose = pose, .speed = speed});
    ranges.assign(360, static_cast<float>(50 + 0.01 * (i % 7)));  // a wall far away
    base.add(ScanView{.time = now,
                      .angle_min = -3.14,
                      .angle_increment = 0.0175,
                      .range_min = 0.1,
                      .range_max = 60,
                      .ranges = ranges},
             {});
    const MoveStatus status = base.cycle(now);
    if (auto request = base.take_request()) {
      base.give(planner.plan(*request, clock));
    }
    speed = status.command.speed;
    pose = drive_arc(pose, status.command.curvature, speed * 0.05);
    if (i % 40 == 0 || status.state == MoveState::kSucceeded) {
      std::cout << pose.x << ' ' << pose.y << ' ' << pose.heading << ' ' << to_string(status.state)
                << '\n';
    }
    if (status.state == MoveState::kSucceeded || status.state == MoveState::kFailed) {
      return status.state == MoveState::kSucceeded ? 0 : 1;
    }
  }
  return 1;
}
