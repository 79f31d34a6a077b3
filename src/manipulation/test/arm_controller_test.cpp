// SPDX-License-Identifier: Apache-2.0
#include "pipescout/manipulation/arm_controller.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "arm_bench.hpp"

namespace pipescout::manipulation {
namespace {

using test::ArmBench;

bool at_rest(const ArmCommand& command) {
  return command.velocity.cwiseAbs().maxCoeff() == 0;
}

bool is(const ArmCommand& command, ArmState state, ArmReason reason) {
  return command.state == state && command.reason == reason;
}

TEST(ArmController, CentresALevelPipe) {
  ArmBench bench;
  bench.pipe_height = 3.2;
  const ArmCommand command = bench.cycles(3);
  EXPECT_TRUE(is(command, ArmState::kTracking, ArmReason::kNone));
  EXPECT_NEAR(bench.section().v, 119.5, 0.1);
  EXPECT_NEAR(bench.section().angle, 0, 1e-3);
  EXPECT_NEAR(command.error_v, 0, 0.1);
  EXPECT_NEAR(command.error_angle, 0, 1e-3);
  EXPECT_EQ(command.error_u, 0);
  EXPECT_TRUE(command.feed_forward);
}

TEST(ArmController, FeedForwardKeepsThePipeInTheMiddleWhileTheVehicleRolls) {
  const auto error_with = [](bool feed_forward) {
    ArmControllerParameters parameters{.feed_forward = feed_forward};
    // The bench has no delay beyond the period.
    parameters.response_time = parameters.period;
    parameters.image_time = feed_forward ? parameters.image_time : 0;
    ArmBench bench(parameters);
    bench.cycles(2);
    double largest = 0;
    for (int i = 0; i < 300; ++i) {
      bench.roll_rate = 0.2 * std::cos(0.05 * i);
      bench.cycle();
      largest = std::max(largest, std::abs(bench.section().v - 119.5));
    }
    return largest;
  };
  EXPECT_LT(error_with(true), 2);    // px
  EXPECT_GT(error_with(false), 10);  // px
}

TEST(ArmController, PapersRuleMovesAtTheEdgeOnly) {
  ArmBench bench({.centring = Centring::kAtEdge, .feed_forward = false, .image_time = 0});
  EXPECT_TRUE(at_rest(bench.cycles(1)));
  // Up to 0.3 of the height off the middle is left alone: 72 of 240 px.
  bench.pipe_height += 0.8;
  EXPECT_TRUE(at_rest(bench.cycles(1)));
  EXPECT_GT(std::abs(bench.section().v - 119.5), 40);
  bench.pipe_height += 0.5;
  EXPECT_FALSE(at_rest(bench.cycles(0.1)));
  EXPECT_TRUE(at_rest(bench.cycles(3)));
  EXPECT_LT(std::abs(bench.section().v - 119.5), 0.05 * 240 + 1);
}

TEST(ArmController, IsIdleUntilJointReadingsCome) {
  ArmBench bench;
  bench.joints_come = false;
  const ArmCommand command = bench.cycles(1);
  EXPECT_TRUE(is(command, ArmState::kIdle, ArmReason::kNoJointReadings));
  EXPECT_FALSE(command.commanded);
}

TEST(ArmController, HoldsFromTheVeryCycleInWhichAnInputIsStale) {
  struct Case {
    bool ArmBench::*input;
    double age;
    ArmReason reason;
  };
  const ArmControllerParameters parameters;
  for (const Case& stale :
       {Case{&ArmBench::joints_come, parameters.joints_stale_after, ArmReason::kStaleJointReadings},
        Case{&ArmBench::odometry_comes, parameters.odometry_stale_after, ArmReason::kStaleOdometry},
        Case{&ArmBench::track_comes, parameters.track_stale_after, ArmReason::kStaleTrack}}) {
    ArmBench bench;
    bench.cycles(1);
    bench.roll_rate = 0.1;  // something to do
    bench.cycles(0.1);
    bench.*stale.input = false;
    const double last = bench.now();
    ArmCommand before;
    ArmCommand command = bench.cycle();
    while (command.state == ArmState::kTracking) {
      ASSERT_LT(bench.now(), last + stale.age + 0.05);
      before = command;
      command = bench.cycle();
    }
    EXPECT_TRUE(is(command, ArmState::kHolding, stale.reason)) << to_string(command.reason);
    // It brakes at once, as hard as it may.
    const double change = parameters.largest_acceleration * parameters.period;
    for (Eigen::Index i = 0; i < command.velocity.size(); ++i) {
      EXPECT_NEAR(std::abs(command.velocity[i]),
                  std::max(0.0, std::abs(before.velocity[i]) - change), 1e-12);
    }
    EXPECT_TRUE(at_rest(bench.cycles(0.3)));
    bench.*stale.input = true;
    EXPECT_EQ(bench.cycles(0.1).state, ArmState::kTracking);
  }
}

TEST(ArmController, WithoutFeedForwardNeedsNoOdometry) {
  ArmBench bench({.feed_forward = false});
  bench.odometry_comes = false;
  EXPECT_EQ(bench.cycles(1).state, ArmState::kTracking);
}

TEST(ArmController, CoastsOnWhatItKnows) {
  ArmBench bench;
  bench.cycles(1);
  bench.track = TrackState::kCoasting;
  bench.roll_rate = 0.1;
  EXPECT_EQ(bench.cycles(1).state, ArmState::kTracking);
  EXPECT_NEAR(bench.section().v, 119.5, 3);
}

TEST(ArmController, HoldsThenSearchesThenStowsWhenThePipeIsLost) {
  const ArmControllerParameters parameters;
  ArmBench bench;
  bench.cycles(1);
  bench.track = TrackState::kLost;
  ArmCommand command = bench.cycles(0.9);
  EXPECT_TRUE(is(command, ArmState::kHolding, ArmReason::kPipeLost));
  EXPECT_TRUE(at_rest(command));
  double highest = 0;
  double lowest = 0;
  for (int i = 0; i < 1150; ++i) {
    command = bench.cycle();
    highest = std::max(highest, bench.section().v - 119.5);
    lowest = std::min(lowest, bench.section().v - 119.5);
  }
  EXPECT_TRUE(is(command, ArmState::kSearching, ArmReason::kPipeLost));
  // Up and down, by nearly the whole amplitude.
  const double swept = 0.9 * 722 * std::tan(parameters.search_amplitude);
  EXPECT_GT(highest, swept);
  EXPECT_LT(lowest, -swept);
  EXPECT_TRUE(is(bench.cycles(1.5), ArmState::kStowing, ArmReason::kSearchedInVain));
  command = bench.cycles(8);
  EXPECT_TRUE(is(command, ArmState::kStowed, ArmReason::kSearchedInVain));
  for (Eigen::Index i = 0; i < command.position.size(); ++i) {
    EXPECT_NEAR(command.position[i], parameters.stow[static_cast<std::size_t>(i)], 0.02);
  }
  // A pipe does not make it come out again; being told to does.
  bench.track = TrackState::kLocked;
  EXPECT_EQ(bench.cycles(1).state, ArmState::kStowed);
  bench.request = ArmRequest::kStow;
  bench.cycle();
  bench.request = ArmRequest::kTrack;
  EXPECT_NE(bench.cycles(0.1).state, ArmState::kStowed);
}

TEST(ArmController, TracksAgainAPipeThatIsSeenAgain) {
  ArmBench bench;
  bench.cycles(1);
  bench.track = TrackState::kLost;
  EXPECT_EQ(bench.cycles(4).state, ArmState::kSearching);
  bench.track = TrackState::kLocked;
  EXPECT_EQ(bench.cycles(2).state, ArmState::kTracking);
  EXPECT_NEAR(bench.section().v, 119.5, 0.5);
}

TEST(ArmController, SearchesFromTheBeginningAndStowsWhenTold) {
  ArmBench bench;
  bench.track = TrackState::kNone;
  EXPECT_TRUE(is(bench.cycles(1), ArmState::kSearching, ArmReason::kNoPipe));
  bench.request = ArmRequest::kStow;
  EXPECT_TRUE(is(bench.cycles(0.1), ArmState::kStowing, ArmReason::kToldToStow));
  EXPECT_TRUE(is(bench.cycles(8), ArmState::kStowed, ArmReason::kToldToStow));
}

TEST(ArmController, TurnsAfterAnEndOfThePipeAsFarAsItMay) {
  const ArmControllerParameters parameters;
  ArmBench bench;
  bench.cycles(1);
  bench.track_comes = false;
  ArmCommand command;
  for (int i = 0; i < 200; ++i) {
    PipeSection section = bench.section();
    section.u = 260;
    section.length = 118;  // its left end is in the image
    section.angle = 0;
    section.time = bench.now() + 0.001;
    bench.controller().observe(section, bench.now());
    command = bench.cycle();
    bench.track_comes = false;
  }
  EXPECT_EQ(command.state, ArmState::kTracking);
  EXPECT_GT(command.error_u, 0);
  const ArmModel arm(camera_arm_urdf(), "base_link", "camera_optical_frame");
  const Eigen::Vector3d looks =
      arm.T_base_camera(command.position).rotation() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(std::atan2(looks.x(), looks.y()), parameters.turn, 0.01);
}

TEST(ArmController, AJointThatDoesNotFollowIsAFaultUntilReset) {
  ArmBench bench;
  bench.cycles(1);
  bench.posture()[2] += 0.4;
  const ArmCommand command = bench.cycle();
  EXPECT_TRUE(is(command, ArmState::kFault, ArmReason::kFollowingError));
  bench.cycles(1);
  EXPECT_EQ(bench.cycle().state, ArmState::kFault);
  bench.controller().reset();
  EXPECT_EQ(bench.cycles(0.1).state, ArmState::kTracking);
}

TEST(ArmController, CommandsNothingFromAnImpossiblePosture) {
  ArmBench bench;
  bench.posture()[0] = 3.2;
  EXPECT_TRUE(is(bench.cycle(), ArmState::kFault, ArmReason::kOutsideLimits));
  EXPECT_FALSE(bench.cycle().commanded);
  bench.controller().reset();
  bench.posture() << 0, 0, 2.6, 0, 2.0, 0;
  EXPECT_TRUE(is(bench.cycle(), ArmState::kFault, ArmReason::kTooClose));
  EXPECT_FALSE(bench.cycle().commanded);
}

TEST(ArmController, ALimitThatIsReachedIsToldAndKept) {
  ArmBench bench;
  bench.cycles(1);
  bench.roll_rate = 0.25;  // rolls over
  ArmCommand command;
  const ArmModel arm(camera_arm_urdf(), "base_link", "camera_optical_frame");
  bool cut = false;
  for (int i = 0; i < 1200; ++i) {
    command = bench.cycle();
    cut = cut || command.clearance_cut || std::ranges::count(command.cuts, JointCut::kPosition) > 0;
    const Clearance clearance = arm.clearance(command.position, -0.35);
    ASSERT_GE(std::min(clearance.self, clearance.plane), 0.03);
    for (Eigen::Index k = 0; k < arm.size(); ++k) {
      ASSERT_GE(command.position[k], arm.joints()[static_cast<std::size_t>(k)].lower);
      ASSERT_LE(command.position[k], arm.joints()[static_cast<std::size_t>(k)].upper);
    }
  }
  EXPECT_TRUE(cut);
}

TEST(ArmController, ClockThatGoesBack) {
  ArmBench bench;
  const ArmCommand command = bench.cycles(2);
  ArmController& controller = bench.controller();
  EXPECT_EQ(controller.step(bench.now() - 0.5, ArmRequest::kTrack).position, command.position);
  EXPECT_EQ(controller.step(NAN, ArmRequest::kTrack).position, command.position);
  // A simulation that begins again.
  EXPECT_EQ(controller.step(0.5, ArmRequest::kTrack).state, ArmState::kIdle);
}

TEST(ArmController, ARushOfCyclesIsNoFasterMotion) {
  ArmBench bench;
  bench.cycles(1);
  bench.roll_rate = 0.2;
  const ArmCommand command = bench.cycle();
  const ArmCommand again = bench.controller().step(bench.now() + 0.001, ArmRequest::kTrack);
  EXPECT_EQ(again.position, command.position);
}

TEST(ArmController, CountsInputsByVerdict) {
  ArmBench bench;
  bench.cycles(1);
  ArmController& controller = bench.controller();
  const double now = bench.now();
  const auto later = [now] { return now + 0.01; };

  PipeSection section = bench.section();
  section.time = later();
  section.u = NAN;
  EXPECT_EQ(controller.observe(section, later()), InputVerdict::kNotANumber);
  section.u = 100;
  section.length = -1;
  EXPECT_EQ(controller.observe(section, later()), InputVerdict::kNotANumber);
  section.length = 300;
  section.range = 1e-200;
  EXPECT_EQ(controller.observe(section, later()), InputVerdict::kNotANumber);
  section.range = NAN;
  section.time = later() + 1;
  EXPECT_EQ(controller.observe(section, later()), InputVerdict::kFromTheFuture);
  section.time = later() - 1;
  EXPECT_EQ(controller.observe(section, later()), InputVerdict::kStale);
  section.time = now - 0.2;
  EXPECT_EQ(controller.observe(section, later()), InputVerdict::kOutOfOrder);
  section.time = later();
  section.width = 640;
  EXPECT_EQ(controller.observe(section, later()), InputVerdict::kOtherImageSize);
  section.width = 320;
  EXPECT_EQ(controller.observe(section, NAN), InputVerdict::kNotANumber);
  EXPECT_EQ(controller.observe(section, later()), InputVerdict::kTaken);
  EXPECT_EQ(controller.section_counts()[static_cast<std::size_t>(InputVerdict::kNotANumber)], 4U);

  const std::vector<std::string> names{"shoulder_pan_joint", "gripper"};
  const std::vector<double> positions{0.1, 0.2};
  EXPECT_EQ(controller.observe({.time = later(), .names = names, .positions = positions}, later()),
            InputVerdict::kPartial);
  EXPECT_EQ(controller.joint_counts()[static_cast<std::size_t>(InputVerdict::kPartial)], 1U);

  VehicleMotion motion{.time = later()};
  motion.R_map_base.coeffs() *= 2;
  EXPECT_EQ(controller.observe(motion, later()), InputVerdict::kNoRotation);
  motion.R_map_base.setIdentity();
  motion.velocity.x() = 1e300;
  EXPECT_EQ(controller.observe(motion, later()), InputVerdict::kNotANumber);
  EXPECT_EQ(controller.motion_counts()[static_cast<std::size_t>(InputVerdict::kNoRotation)], 1U);
}

TEST(ArmController, RefusesParametersThatDoNotFitTheArm) {
  const auto refusal = [](const ArmControllerParameters& parameters) -> std::string {
    try {
      ArmBench bench(parameters);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const auto names = [&refusal](const ArmControllerParameters& parameters, const char* part) {
    return refusal(parameters).find(part) != std::string::npos;
  };
  EXPECT_EQ(refusal({}), "");
  EXPECT_TRUE(names({.period = 0}, "period"));
  EXPECT_TRUE(names({.ready = {1, 2}}, "ready: 2 angles for 6 joints"));
  EXPECT_TRUE(names({.ready = {4, 0, 0, 0, 0, 0}}, "ready of shoulder_pan_joint"));
  EXPECT_TRUE(names({.ready = {0, 0, 0, 0, 0, 0}}, "ready: is singular"));
  EXPECT_TRUE(names({.stow = {0, 0, 2.6, 0, 2.0, 0}}, "stow"));
  EXPECT_TRUE(names({.largest_acceleration = NAN}, "largest_acceleration"));
  EXPECT_TRUE(names({.nearest = 20}, "farthest"));
}

}  // namespace
}  // namespace pipescout::manipulation
