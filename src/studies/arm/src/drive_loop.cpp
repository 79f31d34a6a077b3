// SPDX-License-Identifier: Apache-2.0
#include "drive_loop.hpp"

#include <algorithm>

#include "pipescout/simulation/thermal_camera.hpp"

namespace pipescout::arm_study::internal {
namespace {

constexpr double kRunOut = 50;  // m, of collector before and after the way

/// Steps of the robot from one to the next.
long long steps_of(double period) {
  return std::max(1LL, std::llround(period / simulation::GroundRobot::kStep));
}

}  // namespace

geometry::Camera usual_camera() {
  return geometry::Camera(simulation::ThermalCameraParameters::qvga().camera);
}

simulation::StraightPipe collector_of(const DriveSettings& settings) {
  return {.from = {-kRunOut, settings.distance, settings.pipe_height},
          .to = {settings.length + kRunOut, settings.distance, settings.pipe_height},
          .radius = settings.pipe_radius};
}

ArmLoop::ArmLoop(const DriveSettings& settings, std::uint64_t seed)
    : settling_(settings.settling),
      odometry_(settings.odometry, seed),
      motions_(settings.odometry.latency),
      odometry_steps_(steps_of(1 / settings.odometry.rate)),
      cycle_steps_(steps_of(manipulation::ArmControllerParameters{}.period)) {}

void ArmLoop::step(const simulation::BodyMotion& truth,
                   std::span<const std::unique_ptr<CameraArm>> arms, const DriveEvents& events) {
  const bool cycle = step_ % cycle_steps_ == 0;
  if (step_ % odometry_steps_ == 0 && events.odometry_comes(truth.time)) {
    motions_.push(truth.time, odometry_.measure(truth));
  }
  while (const auto motion = motions_.pop(truth.time)) {
    for (const auto& arm : arms) {
      arm->observe(*motion, truth.time);
    }
  }
  for (const auto& arm : arms) {
    if (cycle) {
      arm->cycle(truth, truth.time >= settling_);
    }
    arm->step();
  }
  if (cycle) {
    events.each_cycle(truth.time);
  }
  ++step_;
}

void drive(const DriveSettings& settings, std::uint64_t seed,
           std::span<const std::unique_ptr<CameraArm>> arms, const DriveEvents& events) {
  const simulation::Terrain ground({.roughness = simulation::iso_8608_density(settings.road),
                                    .hill_height = settings.hill_height},
                                   seed);
  simulation::GroundRobot robot(settings.robot, ground, Eigen::Vector2d::Zero(), 0, seed);
  simulation::CourseController course({.speed = settings.speed}, {{settings.length, 0}});
  ArmLoop loop(settings, seed);

  const long long image_steps = steps_of(1 / settings.track.rate);
  for (long long step = 0; !course.arrived() && events.goes_on(robot.motion().time); ++step) {
    const simulation::BodyMotion& truth = robot.motion();
    if (step % image_steps == 0) {
      for (const auto& arm : arms) {
        arm->take_image(truth, robot.distance());
      }
    }
    loop.step(truth, arms, events);
    robot.command(course.steer(robot));
    robot.step();
  }
}

}  // namespace pipescout::arm_study::internal
