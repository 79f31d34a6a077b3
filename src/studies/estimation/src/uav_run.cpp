// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "pipescout/rack_vision/way_points.hpp"
#include "pipescout/simulation/dryden_wind.hpp"
#include "pipescout/simulation/uav.hpp"
#include "recorder.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;
using rack_vision::WayPoint;

constexpr double kStanding = 5;        // s
constexpr double kFramePeriod = 0.04;  // s, of the camera
constexpr double kRackLength = 10;     // m, along y
constexpr double kRackWidth = 3;       // m, along x
const SE3 kMapFromRack(SO3::about_z(0.6), Vector3d(40, 15, 0));

/// A way through the open first, then along the rack to and fro until the end.
std::vector<WayPoint> flight_plan(double duration, internal::Draw& draw) {
  std::vector<WayPoint> plan;
  const auto add = [&](const Vector3d& place, double yaw, double hold) {
    plan.push_back({.position = place, .yaw = yaw, .hold = hold});
  };
  const auto over_rack = [&](double x, double y, double z) {
    return Vector3d(kMapFromRack * Vector3d(x, y, z));
  };
  const double yaw = draw.uniform(-3, 3);
  add({0, 0, 6}, yaw, kStanding);
  add({draw.uniform(15, 25), draw.uniform(-15, -5), 8}, yaw + 0.5, 0);
  add({draw.uniform(25, 35), draw.uniform(5, 15), 7}, yaw - 0.5, 0);
  bool far = false;
  // Way-points beyond the end do no harm.
  for (double spent = 0; spent < duration; spent += 10) {
    add(over_rack(draw.uniform(0.3, kRackWidth - 0.3), far ? kRackLength - 1 : 1,
                  draw.uniform(2, 3.5)),
        0.6 + draw.uniform(-0.3, 0.3), 0.5);
    far = !far;
  }
  return plan;
}

/// The position loop of an autopilot, on the truth.
simulation::UavCommand follow(const rack_vision::PathPoint& wanted,
                              const simulation::UavState& state) {
  constexpr double kGain = 1;  // 1/s
  const double yaw = state.T_rack_body.rotation().roll_pitch_yaw()[2];
  const Vector3d velocity =
      wanted.velocity + kGain * (wanted.position - state.T_rack_body.translation());
  return {.velocity = SO3::about_z(-yaw) * velocity,
          .yaw_rate = wanted.yaw_rate + kGain * rack_vision::wrap_angle(wanted.yaw - yaw)};
}

bool sees_rack(const Vector3d& eye) {
  constexpr double kBeside = 0.5;  // m
  return eye.x() > -kBeside && eye.x() < kRackWidth + kBeside && eye.y() > 0 &&
         eye.y() < kRackLength && eye.z() > 1 && eye.z() < 5;
}

}  // namespace

VehicleRun uav_run(const RunOptions& options, std::uint64_t seed) {
  options.validate();
  using simulation::Uav;
  VehicleRun run;
  run.vehicle = Vehicle::kUav;
  run.antenna = Vector3d(0.05, -0.03, 0.12);
  run.T_map_rack = kMapFromRack;
  run.rack_position_deviation = 0.3;
  run.rack_rotation_deviation = 0.02;
  internal::Draw survey = internal::make_draw(seed, 14);
  run.T_map_rack_surveyed =
      SE3(kMapFromRack.rotation() * SO3::exp(run.rack_rotation_deviation * survey.normals()),
          kMapFromRack.translation() + run.rack_position_deviation * survey.normals());
  internal::Draw draw = internal::make_draw(seed, 11);
  internal::Draw losses = internal::make_draw(seed, 12);
  internal::Recorder recorder(options, run, seed);

  constexpr int kStepsPerGust = 10;
  constexpr double kWindDirection = 0.7;  // rad
  simulation::DrydenWind wind({.speed_at_20_feet = 5,
                               .direction = kWindDirection,
                               .height = 6,
                               .period = kStepsPerGust * Uav::kStep},
                              seed);
  const Vector3d mean_wind =
      wind.model().mean_speed * Vector3d(std::cos(kWindDirection), std::sin(kWindDirection), 0);
  const auto plan = flight_plan(options.duration, draw);
  const rack_vision::WayPointPath path(plan, {.largest_speed = 1.5, .largest_acceleration = 1});
  Uav uav({}, plan.front().position, plan.front().yaw, mean_wind, seed);

  simulation::WindSample air;
  double way = 0;
  double lost_until = 0;
  const int steps = static_cast<int>(options.duration / Uav::kStep);
  const int frame_steps = static_cast<int>(std::lround(kFramePeriod / Uav::kStep));
  for (int i = 0; i <= steps; ++i) {
    const double time = i * Uav::kStep;
    const simulation::UavState& state = uav.state();
    recorder.sample({.time = time,
                     .T_map_body = state.T_rack_body,
                     .velocity = state.velocity,
                     .acceleration = state.acceleration,
                     .angular_rate = state.angular_rate},
                    way);
    if (time < kStanding && !options.in_flight) {  // held as it will hover, until it is let go
      continue;
    }
    if (i % frame_steps == 0) {
      // Tracking is lost now and then, and takes its time to be found again.
      constexpr double kMeanSpacing = 30;  // s
      if (losses.happens(kFramePeriod / kMeanSpacing)) {
        lost_until = time + losses.uniform(0.5, 2.5);
      }
      const SE3 T_rack_body = kMapFromRack.inverse() * state.T_rack_body;
      if (time >= lost_until && sees_rack(T_rack_body.translation())) {
        recorder.visual_pose(time, T_rack_body);
      }
    }
    if (i % kStepsPerGust == 0) {
      air = wind.next();
      uav.command(follow(path.at(time), state));
    }
    way += state.velocity.norm() * Uav::kStep;
    uav.step(air);
  }
  recorder.finish();
  return run;
}

}  // namespace pipescout::estimation_study
