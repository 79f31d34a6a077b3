// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_study/planning_score.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/planning/tour.hpp"

namespace pipescout::navigation_study {

using navigation::PathPose;
using navigation::Plan;
using navigation::Pose2d;

namespace {

bool is_free(const navigation::LatticePlanner& planner, const StudyRobot& robot, const Plan& plan) {
  return std::none_of(plan.path.poses().begin(), plan.path.poses().end(),
                      [&](const PathPose& pose) {
                        return collides(robot.footprint, planner.grid(), pose.pose,
                                        navigation::UnknownCells::kBlocked);
                      });
}

}  // namespace

navigation::LatticePlanner shortest_path_planner(const navigation::OccupancyGrid& grid,
                                                 const StudyRobot& robot) {
  return {grid,
          robot.footprint,
          navigation::generate_primitives(robot.turning_radius, robot.spacing),
          {.reverse_factor = 1, .cusp_cost = 0, .steering_cost = 0, .nearness_factor = 0}};
}

PathSample score_path(navigation::LatticePlanner& planner, const StudyRobot& robot,
                      const Pose2d& start, const Pose2d& goal, double deadline,
                      const PlanningClocks& clocks) {
  constexpr double kCurvatureRounding = 1e-6;  // 1/m
  constexpr double kGoalPosition = 1e-3;       // m
  constexpr double kGoalHeading = 1e-3;        // rad
  PathSample sample;
  const double begin = clocks.time();
  double asked = clocks.work();
  bool stopped = false;
  const Plan plan = planner.plan(
      start, goal,
      [&] {
        stopped = clocks.time() - begin >= deadline;
        asked = stopped ? asked : clocks.work();
        return stopped;
      },
      [&](const navigation::Path&, double) {
        sample.first = sample.first == 0 ? clocks.time() - begin : sample.first;
      });
  sample.total = clocks.time() - begin;
  sample.overrun = stopped ? clocks.work() - asked : 0;
  sample.status = plan.status;
  if (plan.status != navigation::PlanStatus::kFound) {
    return sample;
  }
  sample.length = plan.path.length();
  sample.suboptimality = plan.suboptimality;
  sample.curvature_kept =
      plan.path.largest_curvature() <= 1 / robot.turning_radius + kCurvatureRounding;
  const Pose2d& end = plan.path.poses().back().pose;
  sample.goal_met = distance(end, goal) < kGoalPosition &&
                    std::abs(navigation::wrap_angle(end.heading - goal.heading)) < kGoalHeading;
  sample.free = is_free(planner, robot, plan);
  return sample;
}

ReplanSample score_replan(navigation::LatticePlanner& planner, const StudyRobot& robot,
                          const Pose2d& start, const Pose2d& goal, double deadline,
                          statistics::Draw& draw, const Clock& clock) {
  using navigation::CellChange;
  using navigation::CellState;
  constexpr double kObstacle = 0.5;  // m
  ReplanSample sample;
  double begin = clock();
  const auto should_stop = [&] { return clock() - begin >= deadline; };
  const Plan first =
      planner.plan(start, goal, should_stop, [&](const navigation::Path&, double /*cost*/) {
        sample.first = sample.first == 0 ? clock() - begin : sample.first;
      });
  sample.first_found = first.status == navigation::PlanStatus::kFound;
  if (!sample.first_found) {
    return sample;
  }
  const Pose2d on_path = first.path.at(first.path.length() * draw.uniform(1.0 / 3, 2.0 / 3)).pose;
  std::vector<CellChange> obstacle;
  std::vector<CellChange> before;
  const navigation::OccupancyGrid& grid = planner.grid();
  const auto size = static_cast<int>(std::lround(kObstacle / grid.resolution()));
  const navigation::Cell middle = grid.cell_at(on_path.position()).value();
  for (int row = middle.row - size / 2; row <= middle.row + size / 2; ++row) {
    for (int column = middle.column - size / 2; column <= middle.column + size / 2; ++column) {
      if (grid.contains({column, row})) {
        before.push_back({{column, row}, grid.at({column, row})});
        obstacle.push_back({{column, row}, CellState::kOccupied});
      }
    }
  }
  begin = clock();
  planner.change(obstacle);
  const Plan again = planner.replan(start, should_stop);
  sample.again = clock() - begin;
  sample.found = again.status == navigation::PlanStatus::kFound;
  sample.free = is_free(planner, robot, again);
  planner.change(before);
  return sample;
}

double score_tour(std::uint64_t seed) {
  const CollectorField field = draw_collector_field(seed);
  navigation::RoutePlanner planner(field.graph, navigation::length_cost());
  const auto rows = tour_rows(*field.graph, field.rows, navigation::RowSides::kOne);
  const navigation::Tour tour = plan_tour(planner, 0, rows, [] { return false; });
  const bool complete = std::all_of(rows.begin(), rows.end(), [&](const auto& row) {
    return std::any_of(tour.edges.begin(), tour.edges.end(), [&](std::uint32_t edge) {
      return edge == row.edge || edge == row.opposite;
    });
  });
  return complete && tour.lower_bound > 0 ? tour.cost / tour.lower_bound : 0;
}

}  // namespace pipescout::navigation_study
