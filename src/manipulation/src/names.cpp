// SPDX-License-Identifier: Apache-2.0
#include "pipescout/manipulation/arm_controller.hpp"

namespace pipescout::manipulation {

const char* to_string(InputVerdict verdict) noexcept {
  switch (verdict) {
    case InputVerdict::kTaken:
      return "taken";
    case InputVerdict::kNotANumber:
      return "not a number";
    case InputVerdict::kNoRotation:
      return "no rotation";
    case InputVerdict::kPartial:
      return "part of the joints";
    case InputVerdict::kFromTheFuture:
      return "from the future";
    case InputVerdict::kStale:
      return "stale";
    case InputVerdict::kOutOfOrder:
      return "out of order";
    case InputVerdict::kOtherImageSize:
      return "other image size";
    case InputVerdict::kOfOthers:
      return "of other devices";
  }
  return "unknown";
}

const char* to_string(ArmState state) noexcept {
  switch (state) {
    case ArmState::kIdle:
      return "idle";
    case ArmState::kTracking:
      return "tracking";
    case ArmState::kHolding:
      return "holding";
    case ArmState::kSearching:
      return "searching";
    case ArmState::kStowing:
      return "stowing";
    case ArmState::kStowed:
      return "stowed";
    case ArmState::kFault:
      return "fault";
  }
  return "unknown";
}

const char* to_string(ArmReason reason) noexcept {
  switch (reason) {
    case ArmReason::kNone:
      return "";
    case ArmReason::kNoJointReadings:
      return "no joint states yet";
    case ArmReason::kStaleJointReadings:
      return "joint states are stale";
    case ArmReason::kNoIntrinsics:
      return "the camera's intrinsics are unknown";
    case ArmReason::kStaleOdometry:
      return "odometry is stale";
    case ArmReason::kNoPipe:
      return "no pipe detected yet";
    case ArmReason::kStaleTrack:
      return "the track of the pipe is stale";
    case ArmReason::kPipeLost:
      return "the pipe is lost";
    case ArmReason::kSearchedInVain:
      return "the search found nothing";
    case ArmReason::kToldToStow:
      return "stow was requested";
    case ArmReason::kFollowingError:
      return "a joint deviates too far from its command";
    case ArmReason::kOutsideLimits:
      return "the arm is beyond a joint limit";
    case ArmReason::kTooClose:
      return "the arm is too close to itself or the ground";
  }
  return "unknown";
}

}  // namespace pipescout::manipulation
