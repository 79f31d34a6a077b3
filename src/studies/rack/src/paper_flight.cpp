// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/paper_flight.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>

#include "pipescout/rack_vision/way_points.hpp"
#include "pipescout/simulation/dryden_wind.hpp"
#include "pipescout/simulation/uav.hpp"

namespace pipescout::rack_study {
namespace {

using rack_vision::RackModel;
using rack_vision::WayPoint;
using rack_vision::WayPointPath;

constexpr double kInch = 0.0254;
constexpr double kLength = 10;  // m
constexpr double kGap = 0.1;    // m

/// Looking from `eye` at (1, 5, 0), the image's x axis towards rack x, turned by `yaw`.
geometry::SO3 looking(const Eigen::Vector3d& eye, double yaw) {
  const Eigen::Vector3d z = (Eigen::Vector3d(1, 5, 0) - eye).normalized();
  const Eigen::Vector3d x = (Eigen::Vector3d::UnitX() - z.x() * z).normalized();
  Eigen::Matrix3d R_rack_camera;
  R_rack_camera << x, z.cross(x), z;
  return geometry::SO3::about_z(yaw) * geometry::SO3::from_matrix(R_rack_camera);
}

double summed_diameters(const RackModel& model) {
  double sum = 0;
  for (const auto& pipe : model.pipes) {
    if (pipe.direction.isApprox(Eigen::Vector3d::UnitY())) {
      sum += 2 * pipe.largest_radius();
    }
  }
  return sum;
}

/// An autopilot's position loop on the true pose: where the camera is, not how it is steered, is
/// what this flight is for.
simulation::UavCommand follow(const rack_vision::PathPoint& wanted,
                              const simulation::UavState& state) {
  constexpr double kGain = 1.0;  // 1/s
  const double yaw = state.T_rack_body.rotation().roll_pitch_yaw()[2];
  const Eigen::Vector3d velocity =
      wanted.velocity + kGain * (wanted.position - state.T_rack_body.translation());
  return {.velocity = geometry::SO3::about_z(-yaw) * velocity,
          .yaw_rate = wanted.yaw_rate + kGain * rack_vision::wrap_angle(wanted.yaw - yaw)};
}

}  // namespace

RackModel parallel_rack(int count) {
  std::vector<rack_vision::RowPipe> row;
  for (int i = 0; i < count; ++i) {
    const double radius = (i % 2 == 0 ? 6 : 8) * kInch;
    row.push_back({.name = "pipe " + std::to_string(i + 1),
                   .radii = {{0, radius}, {kLength, radius}},
                   .gap = kGap});
  }
  RackModel model;
  model.pipes = rack_vision::row_of_pipes(row);
  model.validate();
  return model;
}

RackModel paper_rack(int count) {
  const std::array<rack_vision::RowPipe, 4> row{{
      {"pipe 1", {{0, 0.15}, {4.85, 0.15}, {5.15, 0.20}, {kLength, 0.20}}, kGap},
      {"pipe 2", {{0, 0.15}, {kLength, 0.15}}, kGap},
      {"pipe 3", {{0, 0.20}, {kLength, 0.20}}, kGap},
      {"pipe 4", {{0, 0.18}, {kLength, 0.18}}, kGap},
  }};
  RackModel model;
  model.pipes =
      rack_vision::row_of_pipes(std::span(row).first(static_cast<std::size_t>(std::min(count, 4))));
  if (count > 4) {
    constexpr double kRadius = 0.16;
    constexpr double kClearance = 0.001;
    model.pipes.push_back({.name = "pipe 5, across",
                           .start = {-1, 5.8, 0.40 + kRadius + kClearance},
                           .direction = Eigen::Vector3d::UnitX(),
                           .radii = {{0, kRadius}, {4, kRadius}},
                           .movable = false});
  }
  model.validate();
  return model;
}

std::vector<geometry::SE3> paper_flight(const RackModel& model, const FlightSettings& settings,
                                        std::uint64_t seed) {
  const double middle = 0.5 * summed_diameters(model);
  const std::array<WayPoint, 5> way_points{
      {{.position = {middle, 5, 3}, .yaw = 0, .hold = 0},
       {.position = {middle + 1, 6, 3}, .yaw = 0.2, .hold = 0},
       {.position = {middle + 1, 4, 3}, .yaw = -0.2, .hold = 0},
       {.position = {middle + 1, 4, 2.5}, .yaw = -0.2, .hold = 0},
       {.position = {middle, 5, 3}, .yaw = 0, .hold = 0}}};
  const WayPointPath path(way_points, {});
  constexpr int kStepsPerGust = 10;
  constexpr double kWindDirection = 0.7;  // rad: across the pipes and along them
  simulation::DrydenWind wind({.speed_at_20_feet = settings.wind_at_20_feet,
                               .direction = kWindDirection,
                               .height = 6,
                               .period = kStepsPerGust * simulation::Uav::kStep},
                              seed);
  const double mean_speed = settings.gusts ? wind.model().mean_speed : 0;
  const Eigen::Vector3d mean_wind(mean_speed * std::cos(kWindDirection),
                                  mean_speed * std::sin(kWindDirection), 0);
  simulation::Uav uav({}, way_points[0].position, 0, mean_wind, seed);
  simulation::WindSample air;
  std::vector<geometry::SE3> poses;
  const int steps_per_frame = static_cast<int>(std::lround(kFramePeriod / simulation::Uav::kStep));
  const int steps = static_cast<int>(path.duration() / simulation::Uav::kStep);
  for (int i = 0; i <= steps; ++i) {
    if (i % kStepsPerGust == 0) {
      if (settings.gusts) {
        air = wind.next();
      }
      uav.command(follow(path.at(i * simulation::Uav::kStep), uav.state()));
    }
    if (i % steps_per_frame == 0) {
      const geometry::SE3& T_rack_body = uav.state().T_rack_body;
      const double yaw = T_rack_body.rotation().roll_pitch_yaw()[2];
      const geometry::SO3 tilt = T_rack_body.rotation() * geometry::SO3::about_z(-yaw);
      poses.push_back(
          geometry::SE3(tilt * looking(T_rack_body.translation(), yaw), T_rack_body.translation())
              .inverse());
    }
    uav.step(air);
  }
  return poses;
}

}  // namespace pipescout::rack_study
