// SPDX-License-Identifier: Apache-2.0
#include "pipescout/patrol_simulation/plant_parameters.hpp"

#include <numbers>
#include <stdexcept>

namespace pipescout {
namespace {

using simulation::PlantDriveParameters;
using simulation::ThermalSceneParameters;

constexpr std::size_t kObstacleValues = 4;
constexpr std::size_t kStartValues = 3;

// Of the robot in the plant: an electric vehicle whose wheels follow within 50 ms.
constexpr double kResponse = 0.05;  // s
constexpr double kTrack = 0.8;      // m

}  // namespace

PlantParameters::PlantParameters(Parameters& parameters)
    : declared_(parameters, PlantDriveParameters{}) {
  rows_ = parameters.declare<std::int64_t>(
      "plant.rows", 0,
      {.description = "of collectors, between which a navigator drives the robot; 0: it drives by "
                      "itself along one row",
       .integer_range = IntegerRange{0, 20}});
  declared_.real(
      "plant.row_width", [](auto& p) -> double& { return p.yard.row_width; }, {0.5, 10}, "m");
  declared_.real(
      "plant.aisle", [](auto& p) -> double& { return p.yard.aisle; }, {2.5, 20},
      "m, free width between two rows");
  declared_.real(
      "plant.road", [](auto& p) -> double& { return p.yard.road; }, {4, 20},
      "m, width at the ends of the rows");
  declared_.integer(
      "plant.people", [](auto& p) -> int& { return p.yard.people; }, {0, 50}, "that walk about");
  declared_.integer(
      "plant.vehicles", [](auto& p) -> int& { return p.yard.vehicles; }, {0, 20},
      "that drive about");
  declared_.integer(
      "plant.unmapped", [](auto& p) -> int& { return p.yard.unmapped; }, {0, 50},
      "boxes at drawn places in aisles that the map does not show");
  obstacles_ = parameters.declare<std::vector<double>>(
      "plant.obstacles", {},
      {.description = "further such boxes: x, y, half length, half width, m, of each in turn"});
  start_ = parameters.declare<std::vector<double>>(
      "plant.start", {-3.5, 3.25, 0.0},
      {.description = "m, m, rad: pose of the robot in the map at the beginning"});
  leak_rows_ = parameters.declare<std::vector<std::int64_t>>(
      "plant.leak_rows", {}, {.description = "row of each leak in turn"});
  map_folder_ = parameters.declare<std::string>(
      "plant.map_folder", "",
      {.description = "where plant.yaml, plant.pgm and plant.geojson are written when it is "
                      "configured; empty: nowhere"});
  tour_ = parameters.declare<std::vector<std::int64_t>>(
      "plant.tour", {},
      {.description = "edges of the graph along which the operator asks for a tour; empty: all "
                      "with a pipe"});
  with_tour_ = parameters.declare<bool>(
      "plant.with_tour", true,
      {.description =
           "the operator asks for a tour, with which the patrol ends; false: others drive "
           "the robot"});
  time_limit_ = parameters.declare<double>(
      "plant.time_limit", 1800.0,
      {.description = "s, simulated, after which the operator gives up the tour",
       .floating_point_range = FloatingPointRange{1, 1e6}});
  duration_ = parameters.declare<double>(
      "plant.duration", 0.0,
      {.description = "s, simulated, after which a patrol ends that no tour ends, since there is "
                      "none or another goal has preempted it; 0: when it is stopped",
       .floating_point_range = FloatingPointRange{0, 1e6}});
}

PlantDriveParameters PlantParameters::drive(std::uint64_t seed, double row_length) const {
  PlantDriveParameters result = declared_.read();
  result.seed = seed;
  result.yard.rows = static_cast<int>(rows_.get());
  result.yard.row_length = row_length;
  const std::vector<double> boxes = obstacles_.get();
  if (boxes.size() % kObstacleValues != 0) {
    throw std::invalid_argument("parameter 'plant.obstacles': " + std::to_string(boxes.size()) +
                                " values are no multiple of 4");
  }
  for (std::size_t i = 0; i < boxes.size(); i += kObstacleValues) {
    result.obstacles.push_back({.centre = {boxes[i], boxes[i + 1]},
                                .half_length = boxes[i + 2],
                                .half_width = boxes[i + 3]});
  }
  const std::vector<double> start = start_.get();
  if (start.size() != kStartValues) {
    throw std::invalid_argument("parameter 'plant.start': " + std::to_string(start.size()) +
                                " values, not x, y and heading");
  }
  result.start = {start[0], start[1], start[2]};
  return result;
}

void PlantParameters::lay_out(const PlantDriveParameters& plant,
                              const std::vector<simulation::ThermalLeak>& leaks,
                              simulation::ThermalPatrolParameters& patrol) const {
  const std::vector<std::int64_t> leak_rows = leak_rows_.get();
  if (leak_rows.size() != leaks.size()) {
    throw std::invalid_argument("parameter 'plant.leak_rows': " + std::to_string(leak_rows.size()) +
                                " values for " + std::to_string(leaks.size()) + " leaks");
  }
  const double pitch = plant.yard.aisle + plant.yard.row_width;
  patrol.distance = pitch / 2;
  std::vector<ThermalSceneParameters> rows(static_cast<std::size_t>(plant.yard.rows), patrol.scene);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ThermalSceneParameters& row = rows[i];
    const double y = static_cast<double>(i) * pitch;
    const bool faces_up = i % 2 == 0;
    row.T_map_row =
        faces_up ? geometry::SE3(geometry::SO3::about_z(std::numbers::pi), {row.length, y, 0})
                 : geometry::SE3(geometry::SO3(), {0, y, 0});
    row.seed += i;
    row.object.distance = patrol.distance;
  }
  for (std::size_t i = 0; i < leaks.size(); ++i) {
    const std::int64_t row = leak_rows[i];
    if (row < 0 || row >= plant.yard.rows) {
      throw std::invalid_argument("parameter 'plant.leak_rows': " + std::to_string(row) +
                                  " is not one of " + std::to_string(plant.yard.rows) + " rows");
    }
    rows[static_cast<std::size_t>(row)].leaks.push_back(leaks[i]);
  }
  patrol.scene = rows.front();
  patrol.further_rows.assign(rows.begin() + 1, rows.end());
  patrol.start = plant.start;
  patrol.robot.wheel_base = plant.vehicle.wheel_base;
  patrol.robot.track = kTrack;
  patrol.robot.wheels_ahead = plant.vehicle.wheel_base / 2;  // from the rear axle
  patrol.robot.drive_time = kResponse;
  patrol.robot.steer_time = kResponse;
  patrol.robot.largest_acceleration = plant.vehicle.largest_deceleration;
}

}  // namespace pipescout
