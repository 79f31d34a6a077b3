// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_study/planning_score.hpp"

#include <gtest/gtest.h>

namespace pipescout::navigation_study {
namespace {

TEST(PlanningScore, PathsThroughTheMazeKeepAllRules) {
  const StudyRobot robot;
  const auto grid = draw_maze(1);
  auto planner = shortest_path_planner(grid, robot);
  statistics::Draw draw(1, 10);
  for (int i = 0; i < 5; ++i) {
    const auto start = draw_free_pose(draw, grid, robot.footprint);
    const auto goal = draw_free_pose(draw, grid, robot.footprint);
    // A clock that counts its readings: the same on every machine.
    double now = 0;
    const Clock clock = [&] { return now += 1e-3; };
    const PathSample sample = score_path(planner, robot, start, goal, 3, {clock, clock});
    EXPECT_EQ(sample.status, navigation::PlanStatus::kFound);
    EXPECT_TRUE(sample.curvature_kept && sample.goal_met && sample.free);
    EXPECT_GT(sample.first, 0);
    EXPECT_LE(sample.first, sample.total);
  }
}

TEST(PlanningScore, AnObstacleOnThePathIsPlannedAround) {
  const StudyRobot robot;
  const auto grid = draw_plant(2);
  auto planner = shortest_path_planner(grid, robot);
  statistics::Draw draw(2, 11);
  double now = 0;
  int planned_again = 0;
  for (int i = 0; i < 5; ++i) {
    const auto start = draw_free_pose(draw, grid, robot.footprint);
    const auto goal = draw_free_pose(draw, grid, robot.footprint);
    const ReplanSample sample =
        score_replan(planner, robot, start, goal, 10, draw, [&] { return now += 1e-3; });
    planned_again += sample.found ? 1 : 0;
    EXPECT_TRUE(sample.free);
    EXPECT_EQ(planner.grid(), grid);
  }
  EXPECT_GE(planned_again, 4);
}

TEST(PlanningScore, ToursAreCompleteAndNearTheirBound) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const double over = score_tour(seed);
    EXPECT_GE(over, 1);
    EXPECT_LE(over, 1.1);
  }
}

TEST(DrawnMaps, RoadsAreReproducible) {
  const auto a = draw_roads(5, 20);
  const auto b = draw_roads(5, 20);
  ASSERT_EQ(a->edges().size(), b->edges().size());
  EXPECT_EQ(a->edges().back().cost, b->edges().back().cost);
  EXPECT_EQ(a->nodes().size(), 400U);
}

}  // namespace
}  // namespace pipescout::navigation_study
