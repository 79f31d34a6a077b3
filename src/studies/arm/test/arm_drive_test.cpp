// SPDX-License-Identifier: Apache-2.0
#include "pipescout/arm_study/arm_drive.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "pipescout/arm_study/arm_faults.hpp"

namespace pipescout::arm_study {
namespace {

DriveSettings short_drive() {
  return {.length = 200, .settling = 10};
}

TEST(ArmDrive, FeedForwardHoldsThePipeSteadierThanTheImageAlone) {
  const auto scores = run_drive(short_drive(), arm_rules(), 1);
  ASSERT_EQ(scores.size(), 4U);
  const DriveScore& paper = scores[1];
  const DriveScore& image_only = scores[2];
  const DriveScore& ours = scores[3];
  EXPECT_LT(ours.centre_rms(), image_only.centre_rms());
  EXPECT_LT(image_only.centre_rms(), paper.centre_rms());
  EXPECT_LT(ours.angle_rms(), paper.angle_rms());
  EXPECT_EQ(ours.whole, ours.samples);
  EXPECT_GT(ours.samples, 2000U);
  for (const DriveScore& score : scores) {
    EXPECT_EQ(score.limit_violations, 0U) << score.rule;
  }
  EXPECT_EQ(scores[0].moving_percent, 0);
}

TEST(ArmDrive, IsTheSameEveryTime) {
  DriveSettings settings = short_drive();
  settings.length = 60;
  settings.settling = 5;
  const auto once = run_drive(settings, arm_rules(), 3);
  const auto again = run_drive(settings, arm_rules(), 3);
  const auto other = run_drive(settings, arm_rules(), 4);
  EXPECT_EQ(once.back().centre_square, again.back().centre_square);
  EXPECT_NE(once.back().centre_square, other.back().centre_square);
}

TEST(ArmDrive, OnLevelGroundAndWithoutErrorsTheErrorIsSmall) {
  DriveSettings settings = short_drive();
  settings.road = simulation::RoadClass::kA;
  settings.hill_height = 0;
  settings.track.position_deviation = 0;
  settings.track.angle_deviation = 0;
  settings.odometry.tilt_deviation = 0;
  settings.odometry.velocity_deviation = 0;
  settings.odometry.rate_deviation = 0;
  settings.joint_zero_deviation = 0;
  const auto scores = run_drive(settings, {arm_rules().back()}, 1);
  EXPECT_LT(scores[0].centre_rms(), 1);
}

TEST(ArmDrive, RefusesNonsense) {
  DriveSettings settings = short_drive();
  settings.speed = 0;
  EXPECT_THROW((void)run_drive(settings, arm_rules(), 1), std::invalid_argument);
  settings = short_drive();
  settings.track.rate = NAN;
  EXPECT_THROW((void)run_drive(settings, arm_rules(), 1), std::invalid_argument);
}

TEST(ArmFaults, EachEndsInASafeState) {
  for (const FaultScore& score : run_faults({}, 1)) {
    EXPECT_TRUE(score.safe) << score.fault << ": " << to_string(score.state) << ", "
                            << to_string(score.reason) << ", " << score.fastest_at_end << " rad/s, "
                            << score.limit_violations << " violations";
  }
}

}  // namespace
}  // namespace pipescout::arm_study
