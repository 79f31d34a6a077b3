// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipescout/arm_study/arm_drive.hpp"

/// What the arm does when something goes wrong on a drive. Units and frames as in arm_drive.hpp.
namespace pipescout::arm_study {

struct FaultScore {
  std::string fault;
  /// Of the last cycle, a minute after the fault.
  manipulation::ArmState state = manipulation::ArmState::kIdle;
  manipulation::ArmReason reason = manipulation::ArmReason::kNone;
  double fastest_at_end = 0;         ///< rad/s, of any joint, in the last second
  std::size_t limit_violations = 0;  ///< as DriveScore's, of the whole drive
  /// In the state that is safe after such a fault, at rest where that is one of rest, and no limit
  /// was violated on the way.
  bool safe = false;
};

/// Drives of 80 s with the arm always centred by feed-forward; from 20 s on: the tracker sees no
/// pipe any more (safe: stowed); odometry comes no more (safe: holding, at rest); the pipe sinks by
/// 0.5 m/s, until a joint is at its limit (safe: stowed, for it is lost then). Throws as
/// DriveSettings::validate.
[[nodiscard]] std::vector<FaultScore> run_faults(const DriveSettings& settings, std::uint64_t seed);

}  // namespace pipescout::arm_study
