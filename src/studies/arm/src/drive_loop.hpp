// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "camera_arm.hpp"

namespace pipescout::arm_study::internal {

/// The paper's.
[[nodiscard]] geometry::Camera usual_camera();
/// Where the collector is.
[[nodiscard]] simulation::StraightPipe collector_of(const DriveSettings& settings);

/// What happens in a drive beside the arms; asked every step of the robot.
struct DriveEvents {
  std::function<bool(double time)> goes_on = [](double) { return true; };
  std::function<bool(double time)> odometry_comes = [](double) { return true; };
  std::function<void(double time)> each_cycle = [](double) {};
};

/// What becomes of arms in each step of the robot that they are on: odometry comes, controllers
/// have their cycles, joints move.
class ArmLoop {
 public:
  ArmLoop(const DriveSettings& settings, std::uint64_t seed);
  void step(const simulation::BodyMotion& truth, std::span<const std::unique_ptr<CameraArm>> arms,
            const DriveEvents& events);

 private:
  double settling_;  // s
  OdometrySensor odometry_;
  Delayed<manipulation::VehicleMotion> motions_;
  long long odometry_steps_;
  long long cycle_steps_;
  long long step_ = 0;
};

/// Drives the robot along the collector until it arrives, with all arms on it.
void drive(const DriveSettings& settings, std::uint64_t seed,
           std::span<const std::unique_ptr<CameraArm>> arms, const DriveEvents& events);

}  // namespace pipescout::arm_study::internal
