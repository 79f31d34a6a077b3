// SPDX-License-Identifier: Apache-2.0
#include "joint_steps.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace pipescout::manipulation::internal {
namespace {

constexpr double kAcceleration = 12;
constexpr double kPeriod = 0.01;

/// Period by period.
double stopping_way(double velocity) {
  double way = 0;
  while (velocity > 0) {
    way += velocity * kPeriod;
    velocity -= kAcceleration * kPeriod;
  }
  return way;
}

RC_GTEST_PROP(StoppingWay, IsThatOfPeriodsOfBraking, ()) {
  const double velocity = *rc::gen::inRange(0, 30000) * 1e-4;
  const double braking = braking_distance(velocity, kAcceleration, kPeriod);
  RC_ASSERT(std::abs(braking + velocity * kPeriod - stopping_way(velocity)) < 1e-12);
}

RC_GTEST_PROP(StoppingWay, FastestThatStopsUsesAllOfIt, ()) {
  const double distance = *rc::gen::inRange(0, 30000) * 1e-4;
  const double velocity = fastest_that_stops(distance, kAcceleration, kPeriod);
  RC_ASSERT(std::abs(stopping_way(velocity) - distance) < 1e-9);
}

TEST(StoppingWay, NoRoomIsRest) {
  EXPECT_EQ(fastest_that_stops(0, kAcceleration, kPeriod), 0);
  EXPECT_EQ(fastest_that_stops(-1e-12, kAcceleration, kPeriod), 0);
  EXPECT_EQ(braking_distance(0, kAcceleration, kPeriod), 0);
}

class Steps {
 public:
  Steps() : model_(camera_arm_urdf(), "base_link", "camera_optical_frame"), steps_(parameters_) {
    at_.position = Eigen::Map<const Eigen::VectorXd>(parameters_.ready.data(), model_.size());
    at_.velocity = JointVector::Zero(model_.size());
  }

  /// Whether a step towards `wanted` keeps all limits.
  [[nodiscard]] bool advance(const JointVector& wanted) {
    const Commanded before = at_;
    steps_.advance(model_, wanted, at_);
    const auto clearance = model_.clearance(at_.position, parameters_.ground);
    bool kept = std::min(clearance.self, clearance.plane) >= parameters_.least_clearance;
    for (Eigen::Index i = 0; i < model_.size(); ++i) {
      const ArmJoint& joint = model_.joints()[static_cast<std::size_t>(i)];
      const double change = std::abs(at_.velocity[i] - before.velocity[i]);
      kept = kept && at_.position[i] >= joint.lower && at_.position[i] <= joint.upper &&
             std::abs(at_.velocity[i]) <= joint.velocity * (1 + 1e-12) &&
             change <= parameters_.largest_acceleration * parameters_.period * (1 + 1e-9) &&
             std::abs(at_.position[i] - before.position[i] - parameters_.period * at_.velocity[i]) <
                 1e-9;
    }
    return kept;
  }

  ArmControllerParameters parameters_;
  ArmModel model_;
  JointSteps steps_;
  Commanded at_;
};

RC_GTEST_PROP(JointSteps, AlwaysKeepAllLimits, (std::uint64_t seed)) {
  // Wild rates, each kept for a while, drive the arm into its stops, itself and the ground.
  Steps steps;
  std::mt19937_64 engine(seed);
  const auto draw = [&engine] { return static_cast<double>(engine() >> 11U) * 0x1p-52 - 1; };
  JointVector wanted(steps.model_.size());
  for (int i = 0; i < 400; ++i) {
    if (i % 40 == 0) {
      for (double& rate : wanted) {
        rate = 6 * draw();
      }
    }
    RC_ASSERT(steps.advance(wanted));
  }
}

TEST(JointSteps, GetWhereTheyAreWantedWithinTheLimits) {
  Steps steps;
  JointVector wanted = JointVector::Zero(steps.model_.size());
  wanted[3] = 0.05;
  EXPECT_TRUE(steps.advance(wanted));
  EXPECT_EQ(steps.at_.velocity, wanted);
  // A joint that goes on stops right at its limit.
  wanted[3] = 100;
  for (int i = 0; i < 300; ++i) {
    EXPECT_TRUE(steps.advance(wanted));
  }
  EXPECT_NEAR(steps.at_.position[3], steps.model_.joints()[3].upper, 1e-9);
  EXPECT_NEAR(steps.at_.velocity[3], 0, 1e-9);
}

TEST(JointSteps, TooFastOnesAreSlowedTogether) {
  Steps steps;
  JointVector wanted = JointVector::Zero(steps.model_.size());
  wanted[0] = 4;
  wanted[3] = 1;
  for (int i = 0; i < 30; ++i) {
    EXPECT_TRUE(steps.advance(wanted));
  }
  EXPECT_NEAR(steps.at_.velocity[0], 2, 1e-12);
  EXPECT_NEAR(steps.at_.velocity[3], 0.5, 1e-12);
}

TEST(JointSteps, TellWhichLimitCutsThem) {
  Steps steps;
  JointVector wanted = JointVector::Zero(steps.model_.size());
  wanted[4] = 1;
  EXPECT_EQ(steps.steps_.advance(steps.model_, wanted, steps.at_).cuts[4], JointCut::kAcceleration);
  EXPECT_EQ(steps.steps_.advance(steps.model_, wanted, steps.at_).cuts[0], JointCut::kNone);
}

TEST(JointSteps, BrakeBeforeTheArmHitsTheHull) {
  Steps steps;
  JointVector wanted = JointVector::Zero(steps.model_.size());
  wanted[1] = 2;
  bool cut = false;
  for (int i = 0; i < 300; ++i) {
    const auto result = steps.steps_.advance(steps.model_, wanted, steps.at_);
    cut = cut || result.clearance_cut;
  }
  EXPECT_TRUE(cut);
  EXPECT_EQ(steps.at_.velocity.norm(), 0);
  const auto clearance = steps.model_.clearance(steps.at_.position, steps.parameters_.ground);
  EXPECT_GE(std::min(clearance.self, clearance.plane), steps.parameters_.least_clearance);
}

}  // namespace
}  // namespace pipescout::manipulation::internal
