// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "heap_guard.hpp"
#include "pipescout/rack_vision/visual_servo.hpp"
#include "pipescout/rack_vision/way_point_mission.hpp"

namespace pipescout::rack_vision {
namespace {

TEST(VisualServoHeap, AFlightTakesNothing) {
  const std::vector<WayPoint> points{{{0.7, 5, 3}, 0, 1}, {{1.7, 6, 3}, 0.2, 1}};
  WayPointMission mission(WayPointPath(points, {}), {});
  VisualServo servo({});
  double commanded = 0;
  const pipescout::test::HeapGuard guard;
  for (int i = 0; i < 1000; ++i) {
    const double now = i * 0.04;
    const PathPoint target = mission.target(now);
    const geometry::SE3 T_rack_camera =
        geometry::SE3(geometry::SO3::about_z(target.yaw), target.position) * downward_camera();
    // A loss on the way.
    if (i < 50 || i > 300) {
      servo.observe({.time = now,
                     .position = T_rack_camera.translation(),
                     .orientation = T_rack_camera.rotation().quaternion()},
                    now);
    }
    std::optional<LevelPose> pose;
    if (const auto T_rack_base = servo.T_rack_base(now)) {
      pose = LevelPose{.time = now, .position = T_rack_base->translation(), .yaw = target.yaw};
    }
    mission.advance(now, pose);
    commanded += servo.step(now, mission.target(now)).linear.norm();
  }
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_TRUE(mission.complete());
  EXPECT_GT(commanded, 0);
}

}  // namespace
}  // namespace pipescout::rack_vision
