// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipescout/arm_study/arm_drive.hpp"

/// Response of the arm to faults during a drive. Units and frames as in arm_drive.hpp.
namespace pipescout::arm_study {

struct FaultScore {
  std::string fault;
  /// Of the last cycle, a minute after the fault.
  manipulation::ArmState state = manipulation::ArmState::kIdle;
  manipulation::ArmReason reason = manipulation::ArmReason::kNone;
  double fastest_at_end = 0;         ///< rad/s, of any joint, in the last second
  std::size_t limit_violations = 0;  ///< as DriveScore's, of the whole drive
  /// In the safe state for this fault, at rest if that state requires it, and without a violated
  /// limit.
  bool safe = false;
};

/// Drives of 80 s with the arm always centred by feed-forward; from 20 s on: the tracker detects no
/// pipe (safe: stowed); odometry stops (safe: holding, at rest); the pipe moves down at 0.5 m/s
/// until a joint is at its limit (safe: stowed, because the pipe is lost). Throws as
/// DriveSettings::validate.
[[nodiscard]] std::vector<FaultScore> run_faults(const DriveSettings& settings, std::uint64_t seed);

}  // namespace pipescout::arm_study
