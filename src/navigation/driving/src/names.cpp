// SPDX-License-Identifier: Apache-2.0
#include "pipescout/driving/local_planner.hpp"

namespace pipescout::navigation {

const char* to_string(DriveState state) {
  switch (state) {
    case DriveState::kIdle:
      return "idle";
    case DriveState::kDriving:
      return "driving";
    case DriveState::kSteering:
      return "steering";
    case DriveState::kWaiting:
      return "waiting";
    case DriveState::kBackingUp:
      return "backing up";
    case DriveState::kReached:
      return "reached";
    case DriveState::kFailed:
      return "failed";
  }
  return "unknown";
}

const char* to_string(DriveReason reason) {
  switch (reason) {
    case DriveReason::kNone:
      return "none";
    case DriveReason::kPaused:
      return "paused";
    case DriveReason::kSpeedLimit:
      return "speed limit";
    case DriveReason::kObstacleNear:
      return "obstacle near";
    case DriveReason::kPathBlocked:
      return "path blocked";
    case DriveReason::kMovingObstacle:
      return "moving obstacle";
    case DriveReason::kLocalisationMissing:
      return "localisation missing";
    case DriveReason::kLocalisationStale:
      return "localisation stale";
    case DriveReason::kLocalisationUncertain:
      return "localisation uncertain";
    case DriveReason::kScanMissing:
      return "scan missing";
    case DriveReason::kScanStale:
      return "scan stale";
    case DriveReason::kScanFrozen:
      return "scan frozen";
    case DriveReason::kTooManyObstacles:
      return "too many obstacles";
    case DriveReason::kOffPath:
      return "off the path";
    case DriveReason::kGoalMissed:
      return "goal missed";
  }
  return "unknown";
}

const char* to_string(DriveInput input) {
  switch (input) {
    case DriveInput::kTaken:
      return "taken";
    case DriveInput::kNotFinite:
      return "not finite";
    case DriveInput::kOutOfOrder:
      return "out of order";
    case DriveInput::kBadGeometry:
      return "bad geometry";
  }
  return "unknown";
}

}  // namespace pipescout::navigation
