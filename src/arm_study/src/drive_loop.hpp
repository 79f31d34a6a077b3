// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "camera_arm.hpp"

namespace pipescout::arm_study::internal {

/// Where the collector is.
[[nodiscard]] simulation::StraightPipe collector_of(const DriveSettings& settings);

/// What happens in a drive beside the arms; asked every step of the robot.
struct DriveEvents {
  std::function<bool(double time)> goes_on = [](double) { return true; };
  std::function<bool(double time)> odometry_comes = [](double) { return true; };
  std::function<void(double time)> each_cycle = [](double) {};
};

/// Drives the robot along the collector until it arrives, with all arms on it.
void drive(const DriveSettings& settings, std::uint64_t seed,
           std::span<const std::unique_ptr<CameraArm>> arms, const DriveEvents& events);

}  // namespace pipescout::arm_study::internal
