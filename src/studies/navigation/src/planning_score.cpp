// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_study/planning_score.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/planning/tour.hpp"

namespace pipescout::navigation_study {

using navigation::PathPose;
using navigation::Plan;
using navigation::Pose2d;

navigation::LatticePlanner shortest_path_planner(const navigation::OccupancyGrid& grid,
                                                 const StudyRobot& robot) {
  return {grid,
          robot.footprint,
          navigation::generate_primitives(robot.turning_radius, robot.spacing),
          {.reverse_factor = 1, .cusp_cost = 0, .steering_cost = 0, .nearness_factor = 0}};
}

PathSample score_path(navigation::LatticePlanner& planner, const StudyRobot& robot,
                      const Pose2d& start, const Pose2d& goal, double deadline,
                      const Clock& clock) {
  constexpr double kCurvatureRounding = 1e-6;  // 1/m
  constexpr double kGoalPosition = 1e-3;       // m
  constexpr double kGoalHeading = 1e-3;        // rad
  PathSample sample;
  const double begin = clock();
  const Plan plan = planner.plan(
      start, goal, [&] { return clock() - begin >= deadline; },
      [&](const navigation::Path&, double) {
        sample.first = sample.first == 0 ? clock() - begin : sample.first;
      });
  sample.total = clock() - begin;
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
  sample.free =
      std::none_of(plan.path.poses().begin(), plan.path.poses().end(), [&](const PathPose& pose) {
        return collides(robot.footprint, planner.grid(), pose.pose,
                        navigation::UnknownCells::kBlocked);
      });
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
