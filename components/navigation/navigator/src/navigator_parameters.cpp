// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigator/navigator_parameters.hpp"

#include <stdexcept>

#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/map_files/route_graph_file.hpp"

namespace pipescout {
namespace {

using navigation::Footprint;
using navigation::GlobalPlannerParameters;
using navigation::MoveBaseParameters;

Footprint read_footprint(const std::vector<double>& values) {
  std::vector<navigation::Point2d> corners;
  for (std::size_t i = 0; i + 1 < values.size(); i += 2) {
    corners.push_back({values[i], values[i + 1]});
  }
  if (values.size() % 2 != 0) {
    throw std::invalid_argument("parameter 'footprint': " + std::to_string(values.size()) +
                                " values are no pairs of x and y");
  }
  try {
    return Footprint::polygon(corners);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("parameter 'footprint': ") + error.what());
  }
}

}  // namespace

NavigatorParameters::NavigatorParameters(Parameters& parameters)
    : base_(parameters, MoveBaseParameters{}), planner_(parameters, GlobalPlannerParameters{}) {
  declare_map(parameters);
  declare_vehicle();
  declare_obstacles();
  declare_inputs();
  declare_inspection();
  declare_planning();
}

void NavigatorParameters::declare_map(Parameters& parameters) {
  map_file_ = parameters.declare<std::string>(
      "map", "", {.description = "occupancy grid: YAML file of map_server"});
  graph_file_ = parameters.declare<std::string>(
      "graph", "",
      {.description = "route graph: GeoJSON file of Nav2's route server; empty: poses only"});
  map_frame_ = parameters.declare<std::string>(
      "map_frame", "map", {.description = "frame of the map, the odometry and the goals"});
  base_frame_ = parameters.declare<std::string>(
      "base_frame", "base_link",
      {.description = "frame of the robot: in the middle of the rear axle, x forward"});
  footprint_ = parameters.declare<std::vector<double>>(
      "footprint", {1.55, 0.5, -0.35, 0.5, -0.35, -0.5, 1.55, -0.5},
      {.description = "m, corners of the robot in base_frame: x, y, x, y, ..."});
  lidar_pose_ = parameters.declare<std::vector<double>>(
      "lidar.pose", {0.8, 0.0, 0.0},
      {.description = "m, m, rad: x, y and yaw of the lidar in base_frame"});
  closed_edges_ = parameters.declare<std::vector<std::int64_t>>(
      "closed_edges", {},
      {.description = "ids of edges of the graph that are closed, in both directions; may be "
                      "changed while driving"});
  planning_readings_ = parameters.declare<std::int64_t>(
      "planning.readings", 0,
      {.description = "questions of the planner that count as a second, for plans that do not "
                      "depend on the machine; 0: its time is real time",
       .integer_range = IntegerRange{0, 100'000'000}});
  steering_speed_ = parameters.declare<double>(
      "steering_speed", 0.001,
      {.description = "m/s, in cmd_vel while the robot stands and turns its wheels: a twist "
                      "without speed says nothing of steering",
       .floating_point_range = FloatingPointRange{0, 0.05}});
  one_sided_ = parameters.declare<bool>(
      "inspection.one_sided", false,
      {.description = "the camera looks to one side only: a tour drives along each edge that is "
                      "asked for in its direction"});
}

void NavigatorParameters::declare_vehicle() {
  base_.real(
      "period", [](auto& p) -> double& { return p.driving.period; }, {0.005, 0.1},
      "s, control period");
  base_.real(
      "wheel_base", [](auto& p) -> double& { return p.driving.wheel_base; }, {0.1, 10}, "m");
  base_.real(
      "largest_steering", [](auto& p) -> double& { return p.driving.largest_steering; },
      {0.01, 1.4}, "rad, of the front wheels");
  base_.real(
      "steering_rate", [](auto& p) -> double& { return p.driving.steering_rate; }, {0.01, 10},
      "rad/s");
  base_.real(
      "delay", [](auto& p) -> double& { return p.driving.delay; }, {0, 0.5},
      "s, until a command acts");
  base_.real(
      "largest_speed", [](auto& p) -> double& { return p.driving.largest_speed; }, {0.05, 10},
      "m/s, forwards");
  base_.real(
      "reverse_speed", [](auto& p) -> double& { return p.driving.reverse_speed; }, {0.05, 10},
      "m/s");
  base_.real(
      "acceleration", [](auto& p) -> double& { return p.driving.acceleration; }, {0.01, 10},
      "m/s^2");
  base_.real(
      "braking", [](auto& p) -> double& { return p.driving.braking; }, {0.01, 10},
      "m/s^2, what may be counted on");
  base_.real(
      "hardest_braking", [](auto& p) -> double& { return p.driving.hardest_braking; }, {0.01, 10},
      "m/s^2, at least `braking`: when that would be too late");
  base_.real(
      "gentle_braking", [](auto& p) -> double& { return p.driving.gentle_braking; }, {0.01, 10},
      "m/s^2, before curves, cusps and the goal, and for pauses");
  base_.real(
      "lateral_acceleration", [](auto& p) -> double& { return p.driving.lateral_acceleration; },
      {0.01, 10}, "m/s^2, in curves");
  base_.real(
      "goal_distance", [](auto& p) -> double& { return p.driving.goal_distance; }, {0.01, 5},
      "m, within which a goal is reached");
  base_.real(
      "goal_heading", [](auto& p) -> double& { return p.driving.goal_heading; }, {0.001, 1},
      "rad, within which a goal is reached");
}

void NavigatorParameters::declare_obstacles() {
  base_.real(
      "obstacles.margin", [](auto& p) -> double& { return p.driving.margin; }, {0, 2},
      "m, around the footprint");
  base_.real(
      "obstacles.tight_margin", [](auto& p) -> double& { return p.driving.tight_margin; }, {0, 2},
      "m, instead of `margin` past what stands still and blocks the path for `wait_time`");
  base_.real(
      "obstacles.tight_speed", [](auto& p) -> double& { return p.driving.tight_speed; }, {0.01, 10},
      "m/s, with no more than `tight_margin`");
  base_.real(
      "obstacles.stop_gap", [](auto& p) -> double& { return p.driving.stop_gap; }, {0, 5},
      "m, it stops so far before an obstacle");
  base_.real(
      "obstacles.slow_zone", [](auto& p) -> double& { return p.driving.slow_zone; }, {0, 5},
      "m, with less beside it, it drives at slow_speed at most");
  base_.real(
      "obstacles.slow_speed", [](auto& p) -> double& { return p.driving.slow_speed; }, {0.01, 10},
      "m/s");
  base_.real(
      "obstacles.largest_offset", [](auto& p) -> double& { return p.driving.largest_offset; },
      {0, 10}, "m, how far it leaves the path for an obstacle");
  base_.real(
      "obstacles.wait_time", [](auto& p) -> double& { return p.driving.wait_time; }, {0, 600},
      "s, before what blocks the path, before it backs up");
  base_.real(
      "obstacles.back_up_length", [](auto& p) -> double& { return p.driving.back_up_length; },
      {0, 10}, "m");
  base_.real(
      "obstacles.replan_after", [](auto& p) -> double& { return p.replan_after; }, {0, 600},
      "s, between plans around what blocks the path");
  base_.integer(
      "obstacles.replans", [](auto& p) -> int& { return p.replans; }, {0, 1000},
      "plans without progress, after which the goal fails");
}

void NavigatorParameters::declare_inputs() {
  base_.real(
      "odometry_stale_after", [](auto& p) -> double& { return p.driving.localisation_stale_after; },
      {0.01, 10}, "s, largest age of the odometry");
  base_.real(
      "scan_stale_after", [](auto& p) -> double& { return p.driving.scan_stale_after; }, {0.01, 10},
      "s, largest age of the scan");
  base_.integer(
      "frozen_scans", [](auto& p) -> int& { return p.driving.frozen_scans; }, {2, 1000},
      "equal scans, after which the lidar is frozen");
  base_.real(
      "largest_sigma", [](auto& p) -> double& { return p.driving.largest_sigma; }, {0.001, 10},
      "m, standard deviation of the position, above which it stops");
  base_.real(
      "largest_heading_sigma", [](auto& p) -> double& { return p.driving.largest_heading_sigma; },
      {0.0001, 1}, "rad, of the heading");
  base_.real(
      "lost_after", [](auto& p) -> double& { return p.lost_after; }, {0, 3600},
      "s, standing for an input, until the goal fails");
}

void NavigatorParameters::declare_inspection() {
  base_.real(
      "inspection.exposure", [](auto& p) -> double& { return p.inspection.exposure; }, {1e-5, 1},
      "s, time constant of the camera");
  base_.real(
      "inspection.focal_length", [](auto& p) -> double& { return p.inspection.focal_length; },
      {10, 1e5}, "px");
  base_.real(
      "inspection.largest_blur", [](auto& p) -> double& { return p.inspection.largest_blur; },
      {0.01, 100}, "px, motion during the exposure");
  base_.real(
      "inspection.arm_rate", [](auto& p) -> double& { return p.inspection.arm_rate; }, {0.01, 10},
      "rad/s, how fast the arm turns to what passes");
  base_.real(
      "inspection.usual_range", [](auto& p) -> double& { return p.inspection.usual_range; },
      {0.1, 1000}, "m to the pipe, if the track has none");
  base_.real(
      "inspection.slow_speed", [](auto& p) -> double& { return p.inspection.slow_speed; },
      {0.01, 10}, "m/s, with a poor track, or none");
  base_.real(
      "inspection.view_angle", [](auto& p) -> double& { return p.view_angle; }, {0.01, 3},
      "rad, how much of a pipe the camera sees, along it");
  base_.integer(
      "inspection.returns", [](auto& p) -> int& { return p.inspection.returns; }, {0, 10},
      "to where a lost pipe was last seen, before it goes on without");
}

void NavigatorParameters::declare_planning() {
  planner_.real(
      "planning.turning_radius", [](auto& p) -> double& { return p.turning_radius; }, {0.1, 1000},
      "m, of planned paths; larger than the vehicle's, so that there is steering left");
  planner_.real(
      "planning.spacing", [](auto& p) -> double& { return p.spacing; }, {0.01, 100},
      "m, of the lattice");
  planner_.real(
      "planning.margin", [](auto& p) -> double& { return p.margin; }, {0, 2},
      "m, around the footprint, where there is room");
  planner_.real(
      "planning.direct_distance", [](auto& p) -> double& { return p.direct_distance; }, {0, 1e4},
      "m, nearer poses are planned for without the graph");
  planner_.real(
      "planning.first_time", [](auto& p) -> double& { return p.first_time; }, {0.01, 60},
      "s, after which planning to a place without a path ends");
  planner_.real(
      "planning.improving_time", [](auto& p) -> double& { return p.improving_time; }, {0, 60},
      "s, for which a first path is improved");
}

NavigatorSettings NavigatorParameters::read() const {
  if (map_file_.share()->empty()) {
    throw std::invalid_argument("parameter 'map': names no file");
  }
  const std::vector<double> lidar = lidar_pose_.get();
  if (lidar.size() != 3) {
    throw std::invalid_argument("parameter 'lidar.pose': " + std::to_string(lidar.size()) +
                                " values, not x, y and yaw");
  }
  const std::string graph = graph_file_.get();
  std::vector<std::string> remarks;
  navigation::HybridMap map{
      graph.empty() ? navigation::RouteGraph() : read_route_graph(graph, remarks),
      read_grid(map_file_.get(), remarks)};
  return {.map = std::move(map),
          .map_remarks = std::move(remarks),
          .footprint = read_footprint(footprint_.get()),
          .base = base_.read(),
          .planner = planner_.read(),
          .map_frame = map_frame_.get(),
          .base_frame = base_frame_.get(),
          .T_base_lidar = {lidar[0], lidar[1], lidar[2]},
          .planning_readings = planning_readings_.get(),
          .steering_speed = steering_speed_.get(),
          .one_sided = one_sided_.get()};
}

}  // namespace pipescout
