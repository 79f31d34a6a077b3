// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/image_scene.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <string>

#include "pipescout/rack_study/paper_flight.hpp"
#include "pipescout/rack_vision/visual_servo.hpp"
#include "pipescout/simulation/dryden_wind.hpp"
#include "pipescout/simulation/uav.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::rack_study {
namespace {

using rack_vision::WayPoint;

constexpr double kHeight = 2.9;         // m, of flights along the rack
constexpr double kMiddle = 0.88;        // m, rack x, of the four pipes
constexpr double kWindHeight = 6;       // m: a rack stands above the ground
constexpr double kWindDirection = 0.7;  // rad: across the pipes and along them
constexpr int kStepsPerGust = 10;

/// An autopilot's position loop on the true pose: the study scores the tracker, not the servo.
simulation::UavCommand follow(const rack_vision::PathPoint& wanted,
                              const simulation::UavState& state) {
  constexpr double kGain = 1.0;  // 1/s
  const double yaw = state.T_rack_body.rotation().roll_pitch_yaw()[2];
  const Eigen::Vector3d velocity =
      wanted.velocity + kGain * (wanted.position - state.T_rack_body.translation());
  return {.velocity = geometry::SO3::about_z(-yaw) * velocity,
          .yaw_rate = wanted.yaw_rate + kGain * rack_vision::wrap_angle(wanted.yaw - yaw)};
}

CameraMotion camera_motion(const simulation::UavState& state, const geometry::SE3& T_body_camera) {
  const geometry::SO3 R_camera_body = T_body_camera.rotation().inverse();
  CameraMotion motion;
  motion.time = state.time;
  motion.T_camera_rack = (state.T_rack_body * T_body_camera).inverse();
  motion.velocity << R_camera_body * (state.T_rack_body.rotation().inverse() * state.velocity),
      R_camera_body * state.angular_rate;
  return motion;
}

}  // namespace

rack_vision::RackModel rack_on_beams() {
  constexpr std::size_t kBeams = 6;
  constexpr double kFirst = 0.4;      // m, rack y
  constexpr double kSpacing = 1.8;    // m
  constexpr double kThickness = 0.2;  // m
  rack_vision::RackModel model = paper_rack(5);
  for (std::size_t i = 0; i < kBeams; ++i) {
    const double begin = kFirst + static_cast<double>(i) * kSpacing;
    model.supports.push_back({.name = "beam " + std::to_string(i + 1),
                              .lowest_corner = {-0.3, begin, -kThickness},
                              .highest_corner = {2.06, begin + kThickness, 0}});
  }
  model.validate();
  return model;
}

rack_vision::RackModel rack_without_beams(double length) {
  const std::array<rack_vision::RowPipe, 4> row{{{"pipe 1", {{0, 0.15}, {length, 0.15}}},
                                                 {"pipe 2", {{0, 0.15}, {length, 0.15}}},
                                                 {"pipe 3", {{0, 0.20}, {length, 0.20}}},
                                                 {"pipe 4", {{0, 0.18}, {length, 0.18}}}}};
  rack_vision::RackModel model;
  model.pipes = rack_vision::row_of_pipes(row);
  model.validate();
  return model;
}

std::vector<WayPoint> inspection_way_points(double duration, std::uint64_t seed) {
  std::vector<WayPoint> way_points{{.position = {0.73, 5, 3}, .yaw = 0, .hold = 0},
                                   {.position = {1.73, 6, 3}, .yaw = 0.2, .hold = 0},
                                   {.position = {1.73, 4, 3}, .yaw = -0.2, .hold = 0},
                                   {.position = {1.73, 4, 2.5}, .yaw = -0.2, .hold = 0},
                                   {.position = {0.73, 5, 3}, .yaw = 0, .hold = 0}};
  std::mt19937_64 engine(seed);
  const auto between = [&engine](double low, double high) {
    return statistics::uniform(engine, low, high);
  };
  while (rack_vision::WayPointPath(way_points, {}).duration() < duration) {
    WayPoint next;
    next.position.x() = between(0.3, 1.5);
    next.position.y() = between(2, 8);
    next.position.z() = between(2.5, 3);
    next.yaw = between(-0.3, 0.3);
    next.hold = between(0, 1);
    way_points.push_back(next);
  }
  return way_points;
}

std::vector<WayPoint> way_points_along(double from, double to) {
  return {{.position = {kMiddle, from, kHeight}, .yaw = 0, .hold = 1},
          {.position = {kMiddle, to, kHeight}, .yaw = 0, .hold = 1}};
}

simulation::RackView view_of(const CameraMotion& motion, const simulation::ChangingRackLight& light,
                             std::uint64_t frame) {
  return {.T_camera_rack = motion.T_camera_rack,
          .velocity = motion.velocity,
          .light = light.at(motion.time),
          .frame = frame};
}

std::vector<CameraMotion> fly_camera(const std::vector<WayPoint>& way_points,
                                     const CameraFlightSettings& settings, std::uint64_t seed) {
  using simulation::Uav;
  const rack_vision::WayPointPath path(way_points, {.largest_speed = settings.largest_speed,
                                                    .largest_yaw_rate = settings.largest_yaw_rate});
  simulation::DrydenWind wind({.speed_at_20_feet = settings.wind_at_20_feet,
                               .direction = kWindDirection,
                               .height = kWindHeight,
                               .period = kStepsPerGust * Uav::kStep},
                              seed);
  const Eigen::Vector3d mean_wind =
      wind.model().mean_speed *
      Eigen::Vector3d(std::cos(kWindDirection), std::sin(kWindDirection), 0);
  Uav uav({}, way_points.front().position, way_points.front().yaw, mean_wind, seed);
  const geometry::SE3 T_body_camera = rack_vision::downward_camera();

  std::vector<CameraMotion> motions;
  simulation::WindSample air;
  const auto images = static_cast<long>(std::lround(settings.duration * settings.frame_rate));
  long step = 0;
  for (long image = 0; image < images; ++image) {
    const long due = std::lround(static_cast<double>(image) / settings.frame_rate / Uav::kStep);
    for (; step < due; ++step) {
      if (step % kStepsPerGust == 0) {
        air = wind.next();
        uav.command(follow(path.at(static_cast<double>(step) * Uav::kStep), uav.state()));
      }
      uav.step(air);
    }
    motions.push_back(camera_motion(uav.state(), T_body_camera));
  }
  return motions;
}

}  // namespace pipescout::rack_study
