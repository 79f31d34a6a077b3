// SPDX-License-Identifier: Apache-2.0
#include "pipescout/arm_study/arm_faults.hpp"

#include <algorithm>
#include <functional>
#include <memory>

#include "drive_loop.hpp"

namespace pipescout::arm_study {
namespace {

using internal::CameraArm;
using manipulation::ArmReason;
using manipulation::ArmState;

constexpr double kFaultTime = 20;  // s
constexpr double kEndTime = 80;    // s
constexpr double kSink = 0.5;      // m/s

enum class Fault { kPipeLost, kOdometryStale, kPipeOutOfReach };

FaultScore run_fault(const DriveSettings& settings, std::uint64_t seed, Fault fault) {
  std::vector<std::unique_ptr<CameraArm>> arms;
  arms.push_back(std::make_unique<CameraArm>(arm_rules().back(), settings, internal::usual_camera(),
                                             internal::collector_of(settings), seed));
  CameraArm& arm = *arms.front();
  FaultScore score;
  internal::DriveEvents events;
  events.goes_on = [](double time) { return time < kEndTime; };
  events.odometry_comes = [fault](double time) {
    return fault != Fault::kOdometryStale || time < kFaultTime;
  };
  events.each_cycle = [&](double time) {
    if (time >= kFaultTime && fault == Fault::kPipeLost) {
      arm.blind();
    }
    if (time >= kFaultTime && fault == Fault::kPipeOutOfReach) {
      arm.move_pipe({0, 0, -kSink * manipulation::ArmControllerParameters{}.period});
    }
    if (time >= kEndTime - 1) {
      score.fastest_at_end =
          std::max(score.fastest_at_end, arm.command().velocity.cwiseAbs().maxCoeff());
    }
  };
  internal::drive(settings, seed, arms, events);
  score.state = arm.command().state;
  score.reason = arm.command().reason;
  score.limit_violations = arm.score().limit_violations;
  return score;
}

}  // namespace

std::vector<FaultScore> run_faults(const DriveSettings& settings, std::uint64_t seed) {
  DriveSettings drive = settings;
  drive.length = std::max(settings.length, 2 * kEndTime * settings.speed);  // it does not arrive
  drive.validate();
  struct Case {
    const char* name;
    Fault fault;
    ArmState state;
    ArmReason reason;
  };
  std::vector<FaultScore> scores;
  for (const Case& expected : {Case{"the tracker detects no pipe", Fault::kPipeLost,
                                    ArmState::kStowed, ArmReason::kSearchedInVain},
                               Case{"odometry stops", Fault::kOdometryStale, ArmState::kHolding,
                                    ArmReason::kStaleOdometry},
                               Case{"the pipe moves out of reach", Fault::kPipeOutOfReach,
                                    ArmState::kStowed, ArmReason::kSearchedInVain}}) {
    FaultScore score = run_fault(drive, seed, expected.fault);
    score.fault = expected.name;
    score.safe = score.state == expected.state && score.reason == expected.reason &&
                 score.fastest_at_end < 1e-3 && score.limit_violations == 0;
    scores.push_back(score);
  }
  return scores;
}

}  // namespace pipescout::arm_study
