// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/arm_dynamics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pipescout::simulation {
namespace {

ArmDynamicsParameters one_joint() {
  return {.lower = {-2}, .upper = {2}, .largest_rate = {1.5}};
}

void run(ArmDynamics& arm, double time) {
  for (int i = 0; i < std::lround(time / ArmDynamics::kStep); ++i) {
    arm.step();
  }
}

using Joint = std::vector<double>;

TEST(ArmDynamics, MovesOnlyWhenTheDelayHasPassed) {
  ArmDynamics arm(one_joint(), Joint{0.5});
  run(arm, 0.1);
  arm.command(Joint{1.0}, Joint{0}, 0);
  run(arm, one_joint().delay);
  EXPECT_EQ(arm.positions()[0], 0.5);
  arm.step();
  EXPECT_GT(arm.positions()[0], 0.5);
  run(arm, 2);
  EXPECT_NEAR(arm.positions()[0], 1.0, 1e-4);
  EXPECT_NEAR(arm.rates()[0], 0, 1e-4);
}

TEST(ArmDynamics, FollowsAStreamOfPointsAtTheirTimesAfterTheDelay) {
  ArmDynamics arm(one_joint(), Joint{0});
  constexpr double kRate = 0.4;
  for (int i = 1; i <= 200; ++i) {
    arm.command(Joint{kRate * 0.01 * i}, Joint{kRate}, 0.01);
    run(arm, 0.01);
  }
  // The point that is due a delay ago.
  EXPECT_NEAR(arm.positions()[0], kRate * (arm.time() - one_joint().delay), 1e-3);
  EXPECT_NEAR(arm.rates()[0], kRate, 1e-3);
  // It stays at the last point, although that had a rate.
  run(arm, 2);
  EXPECT_NEAR(arm.positions()[0], kRate * 2, 1e-4);
}

TEST(ArmDynamics, KeepsRateAndAccelerationAndStops) {
  const ArmDynamicsParameters parameters = one_joint();
  ArmDynamics arm(parameters, Joint{-2});
  arm.command(Joint{50}, Joint{0}, 0);
  double before = 0;
  double fastest = 0;
  for (int i = 0; i < 3000; ++i) {
    arm.step();
    const double rate = arm.rates()[0];
    fastest = std::max(fastest, rate);
    if (arm.positions()[0] < 2) {
      EXPECT_LE(std::abs(rate - before),
                parameters.largest_acceleration * ArmDynamics::kStep + 1e-12);
    }
    before = rate;
  }
  EXPECT_NEAR(fastest, 1.5, 1e-12);
  EXPECT_EQ(arm.positions()[0], 2);
  EXPECT_EQ(arm.rates()[0], 0);
}

TEST(ArmDynamics, EncodersShowWholeSteps) {
  ArmDynamicsParameters parameters = one_joint();
  parameters.resolution = 0.01;
  const ArmDynamics arm(parameters, Joint{0.1234});
  Joint shown(1);
  arm.encoders(shown);
  EXPECT_NEAR(shown[0], 0.12, 1e-12);
}

TEST(ArmDynamics, RefusesNonsense) {
  EXPECT_THROW(ArmDynamics({}, Joint{}), std::invalid_argument);
  EXPECT_THROW(ArmDynamics(one_joint(), Joint{3}), std::invalid_argument);
  EXPECT_THROW(ArmDynamics(one_joint(), Joint{0, 0}), std::invalid_argument);
  ArmDynamicsParameters slow = one_joint();
  slow.largest_rate = {0};
  EXPECT_THROW(slow.validate(), std::invalid_argument);
  ArmDynamics arm(one_joint(), Joint{0});
  EXPECT_THROW(arm.command(Joint{NAN}, Joint{0}, 0), std::invalid_argument);
  EXPECT_THROW(arm.command(Joint{0}, Joint{}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
