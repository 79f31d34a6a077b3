// SPDX-License-Identifier: Apache-2.0
#include "pipescout/move_base/global_planner.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <vector>

#include "pipescout/driving/driving_parameters.hpp"

namespace pipescout::navigation {
namespace {

/// A yard of 60 x 30 m with a block in its middle and a road around it: nodes 10 to 13, edges 0 to
/// 3 counter-clockwise, 100 to 103 back.
HybridMap yard() {
  OccupancyGrid grid({.resolution = 0.1, .width = 600, .height = 300}, CellState::kFree);
  for (int column = 100; column < 500; ++column) {
    for (int row = 100; row < 200; ++row) {
      grid.set({column, row}, CellState::kOccupied);
    }
  }
  std::vector<RouteNode> nodes{{.id = 10, .position = {5, 5}},
                               {.id = 11, .position = {55, 5}},
                               {.id = 12, .position = {55, 25}},
                               {.id = 13, .position = {5, 25}}};
  std::vector<RouteEdge> edges;
  for (std::uint32_t i = 0; i < 4; ++i) {
    edges.push_back({.id = i, .from = i, .to = (i + 1) % 4, .pipe_side = PipeSide::kLeft});
    edges.push_back({.id = 100 + i, .from = (i + 1) % 4, .to = i});
  }
  return {RouteGraph(nodes, edges), grid};
}

class GlobalPlannerTest : public ::testing::Test {
 protected:
  NavigationPlan plan(const NavigationGoal& goal, const std::vector<Point2d>& obstacles = {},
                      const Pose2d& start = {5, 5, 0}) {
    double reading = 0;
    return planner_.plan({.number = 1, .start = start, .goal = goal, .obstacles = obstacles},
                         [&] { return reading += 3e-4; });
  }
  [[nodiscard]] static bool passes(const Path& path, double x, double y, double within) {
    return std::any_of(path.poses().begin(), path.poses().end(), [&](const PathPose& pose) {
      return distance(pose.pose.position(), Point2d{x, y}) < within;
    });
  }

  Footprint footprint_ = Footprint::rectangle(1.55, 0.35, 1.0);
  GlobalPlanner planner_{yard(), footprint_, {}};
};

/// Across the lower road, but for the places of some cells.
std::vector<Point2d> barrier(double x) {
  std::vector<Point2d> cells;
  for (double y = 0.05; y < 10; y += 0.1) {
    cells.push_back({x, y});
  }
  return cells;
}

TEST_F(GlobalPlannerTest, FarPosesAreReachedOverTheGraph) {
  const auto found = plan(PoseGoal{{52, 25, 3.14}});
  ASSERT_EQ(found.failure, NavigationFailure::kNone) << found.text;
  EXPECT_GT(found.cost, 0);
  EXPECT_NEAR(found.path.poses().back().pose.x, 52, 1e-6);
  const auto near = plan(PoseGoal{{20, 5, 0}});
  ASSERT_EQ(near.failure, NavigationFailure::kNone) << near.text;
  EXPECT_EQ(near.cost, 0);
}

TEST_F(GlobalPlannerTest, RoutesAvoidWhatIsClosed) {
  const RouteGoal goal{{11}};
  EXPECT_FALSE(passes(plan(goal).path, 30, 25, 3));
  planner_.close_edges(std::vector<std::int64_t>{0});
  const auto around = plan(goal);
  ASSERT_EQ(around.failure, NavigationFailure::kNone) << around.text;
  EXPECT_TRUE(passes(around.path, 30, 25, 3));
  ASSERT_EQ(around.marks.size(), 1U);
  EXPECT_EQ(around.marks[0].id, 11);
  planner_.close_edges(std::vector<std::int64_t>{2});
  EXPECT_EQ(plan(goal).failure, NavigationFailure::kNoRoute);
  planner_.open_edges(std::vector<std::int64_t>{100});
  EXPECT_FALSE(passes(plan(goal).path, 30, 25, 3));
}

TEST_F(GlobalPlannerTest, SeenObstaclesAreForgottenWithTheNextPlan) {
  const NavigationGoal goal = PoseGoal{{40, 5, 0}};
  EXPECT_LT(plan(goal).path.length(), 36);
  EXPECT_GT(plan(goal, barrier(20)).path.length(), 60);
  EXPECT_LT(plan(goal).path.length(), 36);
}

TEST_F(GlobalPlannerTest, ToursDriveAlongAllRowsAndLeaveOutWhatIsBlocked) {
  const auto found = plan(TourGoal{{0, 2}});
  ASSERT_EQ(found.failure, NavigationFailure::kNone) << found.text;
  ASSERT_EQ(found.marks.size(), 2U);
  for (const PlanMark& mark : found.marks) {
    EXPECT_EQ(mark.pipe_side, mark.backwards ? PipeSide::kRight : PipeSide::kLeft);
  }
  EXPECT_NEAR(found.marks[0].end - found.marks[0].begin, 50, 0.5);
  EXPECT_GE(found.cost, found.lower_bound);
  const auto blocked = plan(TourGoal{{0, 2}}, barrier(30));
  ASSERT_EQ(blocked.failure, NavigationFailure::kNone) << blocked.text;
  EXPECT_EQ(blocked.left_out, std::vector<std::int64_t>{0});
  ASSERT_EQ(blocked.marks.size(), 1U);
  EXPECT_EQ(blocked.marks[0].id, 2);
}

TEST_F(GlobalPlannerTest, EachFailureHasItsReason) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto why = [&](const NavigationGoal& goal) { return plan(goal).failure; };
  EXPECT_EQ(why(PoseGoal{{nan, 0, 0}}), NavigationFailure::kGoalNotFinite);
  EXPECT_EQ(why(PoseGoal{{-5, 5, 0}}), NavigationFailure::kGoalOutside);
  EXPECT_EQ(why(PoseGoal{{30, 15, 0}}), NavigationFailure::kGoalInCollision);
  EXPECT_EQ(why(RouteGoal{}), NavigationFailure::kNoGoals);
  EXPECT_EQ(why(RouteGoal{{7}}), NavigationFailure::kUnknownNode);
  EXPECT_EQ(why(TourGoal{}), NavigationFailure::kNoGoals);
  EXPECT_EQ(why(TourGoal{{7}}), NavigationFailure::kUnknownEdge);
  const NavigationGoal goal = PoseGoal{{20, 5, 0}};
  EXPECT_EQ(plan(goal, {}, {30, 15, 0}).failure, NavigationFailure::kStartInCollision);
  EXPECT_EQ(plan(goal, {}, {-30, 15, 0}).failure, NavigationFailure::kStartOutside);
  EXPECT_EQ(plan(goal, {}, {nan, 15, 0}).failure, NavigationFailure::kStartOutside);
  EXPECT_THROW(GlobalPlanner(yard(), footprint_, {.spacing = 2}), std::invalid_argument);
}

TEST_F(GlobalPlannerTest, WithoutAGraphThereArePosesOnly) {
  planner_ = GlobalPlanner({RouteGraph(), yard().grid}, footprint_, {});
  EXPECT_EQ(plan(PoseGoal{{40, 5, 0}}).failure, NavigationFailure::kNone);
  EXPECT_EQ(plan(PoseGoal{{30, 15, 0}}).failure, NavigationFailure::kGoalInCollision);
  EXPECT_EQ(plan(RouteGoal{{10}}).failure, NavigationFailure::kUnknownNode);
  EXPECT_EQ(plan(TourGoal{{0}}).failure, NavigationFailure::kUnknownEdge);
}

/// What the local planner keeps free around itself, and what it strays by, fit beside the path.
TEST_F(GlobalPlannerTest, KeepsMoreFreeThanTheLocalPlannerAsksFor) {
  EXPECT_GT(GlobalPlannerParameters{}.margin, DrivingParameters{}.margin + 0.1);
  const auto found = plan(PoseGoal{{52, 12, 1.57}});
  ASSERT_EQ(found.failure, NavigationFailure::kNone) << found.text;
  const Footprint wide = footprint_.inflated(DrivingParameters{}.margin + 0.1);
  for (const PathPose& pose : found.path.poses()) {
    EXPECT_FALSE(collides(wide, yard().grid, pose.pose, UnknownCells::kBlocked));
  }
}

TEST_F(GlobalPlannerTest, PosesNearAWallAreReachedWithoutTheMargin) {
  const auto found = plan(PoseGoal{{20, 0.6, 0}});
  EXPECT_EQ(found.failure, NavigationFailure::kNone) << found.text;
}

}  // namespace
}  // namespace pipescout::navigation
