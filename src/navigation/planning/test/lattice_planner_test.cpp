// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/lattice_planner.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "pipescout/planning/reeds_shepp.hpp"

namespace pipescout::navigation {
namespace {

using std::numbers::pi;
constexpr double kRadius = 1.2;

const Footprint kRobot = Footprint::rectangle(1.0, 0.4, 0.8);

/// Stops after so many questions: the same work on every machine.
ShouldStop after(int questions) {
  return [questions]() mutable { return --questions < 0; };
}

OccupancyGrid room(double width, double height) {
  OccupancyGrid grid({.resolution = 0.1,
                      .width = static_cast<int>(width * 10),
                      .height = static_cast<int>(height * 10)},
                     CellState::kFree);
  return grid;
}

void fill(OccupancyGrid& grid, double x, double y, double to_x, double to_y) {
  for (int row = static_cast<int>(y * 10); row < static_cast<int>(to_y * 10); ++row) {
    for (int column = static_cast<int>(x * 10); column < static_cast<int>(to_x * 10); ++column) {
      grid.set({column, row}, CellState::kOccupied);
    }
  }
}

LatticePlanner planner(OccupancyGrid grid, const LatticeSettings& settings = {},
                       const Footprint& footprint = kRobot) {
  return {std::move(grid), footprint, generate_primitives(kRadius, 0.2), settings};
}

/// The path joins both exactly, each step is an arc that can be driven, and nothing is hit.
void expect_drivable(const Plan& plan, const OccupancyGrid& grid, const Pose2d& start,
                     const Pose2d& goal, const Footprint& footprint = kRobot) {
  ASSERT_EQ(plan.status, PlanStatus::kFound) << text_of(plan.status);
  const auto& poses = plan.path.poses();
  EXPECT_NEAR(distance(poses.front().pose, start), 0, 1e-9);
  EXPECT_NEAR(distance(poses.back().pose, goal), 0, 1e-4);
  EXPECT_NEAR(wrap_angle(poses.back().pose.heading - goal.heading), 0, 1e-4);
  EXPECT_LE(plan.path.largest_curvature(), 1 / kRadius + 1e-6);
  EXPECT_GE(plan.suboptimality, 1);
  EXPECT_GE(plan.cost, plan.lower_bound - 1e-6);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ASSERT_FALSE(collides(footprint, grid, poses[i].pose, UnknownCells::kBlocked)) << i;
    if (i > 0) {
      const double length = poses[i].arc_length - poses[i - 1].arc_length;
      const double sign = poses[i - 1].direction == Direction::kForward ? 1 : -1;
      const Pose2d end = drive_arc(poses[i - 1].pose, poses[i - 1].curvature, sign * length);
      ASSERT_NEAR(distance(end, poses[i].pose), 0, 1e-6);
      ASSERT_NEAR(wrap_angle(end.heading - poses[i].pose.heading), 0, 1e-6);
    }
  }
}

void expect_found(const OccupancyGrid& grid, const Pose2d& start, const Pose2d& goal,
                  const Footprint& footprint = kRobot) {
  LatticePlanner lattice = planner(grid, {}, footprint);
  expect_drivable(lattice.plan(start, goal, after(5000)), grid, start, goal, footprint);
}

TEST(LatticePlanner, FreeSpaceIsReedsShepp) {
  const OccupancyGrid grid = room(20, 20);
  LatticePlanner lattice = planner(
      grid, {.reverse_factor = 1, .cusp_cost = 0, .steering_cost = 0, .nearness_factor = 0});
  const Pose2d start{5, 5, 0.3};
  const Pose2d goal{12, 9, 2.5};
  const Plan plan = lattice.plan(start, goal, after(5000));
  expect_drivable(plan, grid, start, goal);
  EXPECT_NEAR(plan.path.length(), reeds_shepp_length(start, goal, kRadius), 1e-6);
  EXPECT_NEAR(plan.suboptimality, 1, 1e-6);
}

TEST(LatticePlanner, TurnsAboutInAnAisleOfThreeMetres) {
  OccupancyGrid grid = room(20, 3);
  expect_found(grid, {5, 1.5, 0}, {12, 1.5, pi});
  expect_found(grid, {5, 1.5, 0}, {5, 1.5, pi});
}

TEST(LatticePlanner, ReversesOutOfADeadEnd) {
  OccupancyGrid grid = room(12, 8);
  fill(grid, 0, 0, 6, 3);
  fill(grid, 0, 4.5, 6, 8);
  // Nose inwards in a slot of 1.5 m.
  const Pose2d start{2, 3.75, pi};
  LatticePlanner lattice = planner(grid);
  const Plan plan = lattice.plan(start, {9, 4, 0}, after(5000));
  expect_drivable(plan, grid, start, {9, 4, 0});
  EXPECT_GT(plan.path.reverse_length(), 3);
}

TEST(LatticePlanner, ParksInANarrowPlace) {
  OccupancyGrid grid = room(12, 8);
  fill(grid, 0, 0, 6, 3.2);
  fill(grid, 0, 4.4, 6, 8);
  expect_found(grid, {9, 6, pi / 2}, {3, 3.8, 0});
  expect_found(grid, {9, 6, pi / 2}, {3, 3.8, pi});
}

/// A way is dug through solid ground by driving it, forwards, in reverse and with cusps: its end is
/// reachable, and must be found.
TEST(LatticePlanner, AGoalThatIsReachableIsFound) {
  // kRobot's and 0.2 m around it.
  constexpr double kFront = 1.2;
  constexpr double kRear = 0.6;
  constexpr double kHalfWidth = 0.6;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    std::mt19937_64 engine(seed);
    OccupancyGrid grid = room(40, 40);
    fill(grid, 0, 0, 40, 40);
    const auto dig = [&](const Pose2d& pose) {
      const Cell middle = grid.cell_at(pose.position()).value();
      for (int row = middle.row - 20; row < middle.row + 20; ++row) {
        for (int column = middle.column - 20; column < middle.column + 20; ++column) {
          const Point2d centre = grid.centre({column, row});
          const Point2d seen = relative(pose, {centre.x, centre.y, 0}).position();
          if (seen.x > -kRear && seen.x < kFront && std::abs(seen.y) < kHalfWidth) {
            grid.set({column, row}, CellState::kFree);
          }
        }
      }
    };
    const Pose2d start{20, 20, static_cast<double>(seed)};
    Pose2d goal = start;
    double sign = 1;
    for (int arc = 0; arc < 5; ++arc) {
      const double share = static_cast<double>(engine() % 9) / 4 - 1;  // of the largest curvature
      sign = engine() % 3 == 0 ? -sign : sign;
      for (int i = 0; i < 30; ++i) {
        dig(goal);
        goal = drive_arc(goal, 0.8 * share / kRadius, sign * 0.1);
      }
    }
    dig(goal);
    SCOPED_TRACE(seed);
    expect_found(grid, start, goal);
  }
}

TEST(LatticePlanner, MeetsEveryFinalHeading) {
  OccupancyGrid grid = room(15, 12);
  fill(grid, 6, 4, 8, 8);
  for (int i = 0; i < 24; ++i) {
    expect_found(grid, {3, 6, 0}, {11, 6, i * pi / 12});
  }
}

TEST(LatticePlanner, LongAndOddFootprints) {
  OccupancyGrid grid = room(20, 12);
  fill(grid, 9, 0, 10, 5);
  fill(grid, 9, 6.6, 10, 12);  // a door of 1.6 m
  expect_found(grid, {4, 3, 0}, {15, 9, 0}, Footprint::rectangle(2.2, 0.3, 0.9));
  expect_found(
      grid, {4, 3, 0}, {15, 9, 0},
      Footprint::polygon({{-0.5, -0.3}, {0.6, -0.3}, {1.2, 0}, {0.6, 0.3}, {0, 0.7}, {-0.5, 0.3}}));
}

TEST(LatticePlanner, AGridThatIsTurnedAndCoarse) {
  OccupancyGrid grid({.resolution = 0.25, .origin = {3, -2, 0.7}, .width = 80, .height = 60},
                     CellState::kFree);
  for (int row = 0; row < 40; ++row) {
    grid.set({40, row}, CellState::kOccupied);
  }
  const Point2d a = grid.centre({20, 20});
  const Point2d b = grid.centre({60, 20});
  expect_found(grid, {a.x, a.y, 1}, {b.x, b.y, -2});
}

TEST(LatticePlanner, SaysWhyThereIsNone) {
  OccupancyGrid grid = room(12, 8);
  fill(grid, 5, 0, 5.2, 8);
  LatticePlanner lattice = planner(grid);
  const Pose2d fine{2, 2, 0};
  const auto status = [&](const Pose2d& start, const Pose2d& goal) {
    const Plan plan = lattice.plan(start, goal, after(5000));
    EXPECT_TRUE(plan.path.empty());
    return plan.status;
  };
  EXPECT_EQ(status(fine, {8, 4, 0}), PlanStatus::kUnreachable);
  EXPECT_EQ(status(fine, {5.1, 4, 0}), PlanStatus::kGoalInCollision);
  EXPECT_EQ(status({5.1, 4, 0}, fine), PlanStatus::kStartInCollision);
  EXPECT_EQ(status(fine, {100, 4, 0}), PlanStatus::kGoalOutside);
  EXPECT_EQ(status({-1, 4, 0}, fine), PlanStatus::kStartOutside);
  EXPECT_EQ(status(fine, {NAN, 4, 0}), PlanStatus::kGoalNotFinite);
  EXPECT_EQ(status({2, 2, INFINITY}, fine), PlanStatus::kStartNotFinite);
  EXPECT_EQ(lattice.plan(fine, {3, 6, 0}, after(0)).status, PlanStatus::kStopped);
  EXPECT_EQ(planner(grid).replan(fine, after(10)).status, PlanStatus::kNotFound);
}

TEST(LatticePlanner, LaterPathsCostLess) {
  OccupancyGrid grid = room(30, 20);
  fill(grid, 8, 0, 9, 14);
  fill(grid, 16, 6, 17, 20);
  LatticePlanner lattice = planner(grid);
  std::vector<double> costs;
  const Plan plan = lattice.plan({3, 3, 0}, {25, 15, 1}, after(3000),
                                 [&](const Path&, double cost) { costs.push_back(cost); });
  expect_drivable(plan, grid, {3, 3, 0}, {25, 15, 1});
  ASSERT_GE(costs.size(), 2U);
  EXPECT_TRUE(std::is_sorted(costs.rbegin(), costs.rend()));
  EXPECT_EQ(costs.back(), plan.cost);
}

TEST(LatticePlanner, ReplansAroundWhatBlocksAndGoesOnWhereFree) {
  OccupancyGrid grid = room(40, 10);
  LatticePlanner lattice = planner(grid);
  const Pose2d start{3, 5, 0};
  const Pose2d goal{37, 5, 0};
  const Plan first = lattice.plan(start, goal, after(1000));
  expect_drivable(first, grid, start, goal);
  const Pose2d here = first.path.at(2).pose;
  const Plan same = lattice.replan(here, after(1000));
  expect_drivable(same, grid, here, goal);
  EXPECT_TRUE(same.reused);
  EXPECT_EQ(same.expansions, 0U);
  std::vector<CellChange> wall;
  for (int row = 30; row < 70; ++row) {
    wall.push_back({{150, row}, CellState::kOccupied});
  }
  lattice.change(wall);
  const Plan around = lattice.replan(here, after(1000));
  expect_drivable(around, lattice.grid(), here, goal);
  EXPECT_TRUE(around.reused);
  EXPECT_FALSE(lattice.is_free(first.path));
  EXPECT_THROW(lattice.change(std::vector<CellChange>{{{400, 0}, CellState::kFree}}),
               std::invalid_argument);
}

TEST(LatticePlanner, LittleIsAskedAfterTheFirstYes) {
  OccupancyGrid grid = room(30, 20);
  fill(grid, 8, 0, 9, 14);
  fill(grid, 16, 6, 17, 20);
  LatticePlanner lattice = planner(grid);
  for (int questions = 0; questions < 400; questions += 7) {
    int asked = 0;
    const Plan plan = lattice.plan({3, 3, 0}, {25, 15, 1}, [&] { return ++asked > questions; });
    EXPECT_LE(asked, questions + 8);
    EXPECT_TRUE(plan.status == PlanStatus::kFound || plan.status == PlanStatus::kStopped);
  }
}

/// Pillars that a path winds between: the cells of the bound are larger than those of the grid.
TEST(LatticePlanner, TheBoundHoldsAmongPillars) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 engine(seed);
    OccupancyGrid grid = room(20, 12);
    for (int i = 0; i < 40; ++i) {
      const double x = 2.5 + static_cast<double>(engine() % 140) / 10;
      const double y = static_cast<double>(engine() % 110) / 10;
      fill(grid, x, y, x + 0.3, y + 0.3);
    }
    // Nearly a disc: what the bound takes the robot for.
    const Footprint robot = Footprint::rectangle(0.3, 0.3, 0.6);
    LatticePlanner lattice = planner(
        grid, {.reverse_factor = 1, .cusp_cost = 0, .steering_cost = 0, .nearness_factor = 0},
        robot);
    const Plan plan = lattice.plan({1, 6, 0}, {19, 6, 0}, after(20000));
    if (plan.status == PlanStatus::kFound) {
      expect_drivable(plan, grid, {1, 6, 0}, {19, 6, 0}, robot);
      EXPECT_LE(plan.suboptimality, 1.35) << seed;
    }
  }
}

TEST(LatticePlanner, PathsStayInTheGridWhereUnknownIsFree) {
  OccupancyGrid grid = room(12, 8);
  fill(grid, 6, 0, 6.3, 8);
  LatticePlanner lattice = planner(grid, {.unknown = UnknownCells::kFree});
  EXPECT_EQ(lattice.plan({3, 4, 0}, {9, 4, 0}, after(5000)).status, PlanStatus::kUnreachable);
}

}  // namespace
}  // namespace pipescout::navigation
