// SPDX-License-Identifier: Apache-2.0
#include "drive_loop.hpp"

#include <algorithm>

namespace pipescout::arm_study::internal {
namespace {

constexpr double kRunOut = 50;  // m, of collector before and after the way

/// Steps of the robot from one to the next.
long long steps_of(double period) {
  return std::max(1LL, std::llround(period / simulation::GroundRobot::kStep));
}

}  // namespace

simulation::StraightPipe collector_of(const DriveSettings& settings) {
  return {.from = {-kRunOut, settings.distance, settings.pipe_height},
          .to = {settings.length + kRunOut, settings.distance, settings.pipe_height},
          .radius = settings.pipe_radius};
}

void drive(const DriveSettings& settings, std::uint64_t seed,
           std::span<const std::unique_ptr<CameraArm>> arms, const DriveEvents& events) {
  const simulation::Terrain ground({.roughness = simulation::iso_8608_density(settings.road),
                                    .hill_height = settings.hill_height},
                                   seed);
  simulation::GroundRobot robot(settings.robot, ground, Eigen::Vector2d::Zero(), 0, seed);
  simulation::CourseController course({.speed = settings.speed}, {{settings.length, 0}});
  OdometrySensor odometry(settings.odometry, seed);
  Delayed<manipulation::VehicleMotion> motions(settings.odometry.latency);

  const long long odometry_steps = steps_of(1 / settings.odometry.rate);
  const long long image_steps = steps_of(1 / settings.track.rate);
  const long long cycle_steps = steps_of(manipulation::ArmControllerParameters{}.period);
  for (long long step = 0; !course.arrived() && events.goes_on(robot.motion().time); ++step) {
    const simulation::BodyMotion& truth = robot.motion();
    if (step % odometry_steps == 0 && events.odometry_comes(truth.time)) {
      motions.push(truth.time, odometry.measure(truth));
    }
    while (const auto motion = motions.pop(truth.time)) {
      for (const auto& arm : arms) {
        arm->observe(*motion, truth.time);
      }
    }
    for (const auto& arm : arms) {
      if (step % image_steps == 0) {
        arm->take_image(truth, robot.distance());
      }
      if (step % cycle_steps == 0) {
        arm->cycle(truth, truth.time >= settings.settling);
      }
      arm->step();
    }
    if (step % cycle_steps == 0) {
      events.each_cycle(truth.time);
    }
    robot.command(course.steer(robot));
    robot.step();
  }
}

}  // namespace pipescout::arm_study::internal
