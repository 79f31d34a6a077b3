// SPDX-License-Identifier: Apache-2.0
#include "resolved_rates.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace pipescout::manipulation::internal {
namespace {

ArmModel camera_arm() {
  return {camera_arm_urdf(), "base_link", "camera_optical_frame"};
}

JointVector posture(std::initializer_list<double> angles) {
  JointVector q(static_cast<Eigen::Index>(angles.size()));
  std::ranges::copy(angles, q.begin());
  return q;
}

TEST(ResolvedRates, MoveTheCameraAsWantedWhereTheArmIsFree) {
  const ArmModel arm = camera_arm();
  const Jacobian jacobian = arm.camera_jacobian(posture({1.5, -0.9, 1.3, 0.1, 1.0, 0}));
  geometry::Vector6d twist;
  twist << 0.05, -0.02, 0.01, 0.3, -0.1, 0.2;
  const JointVector rates = resolved_rates(jacobian, manipulability(jacobian), twist, {});
  EXPECT_LT((jacobian * rates - twist).norm(), 1e-6);
}

TEST(ResolvedRates, StayFiniteInASingularPosture) {
  const ArmModel arm = camera_arm();
  const Jacobian jacobian = arm.camera_jacobian(posture({0, 0, 0, 0, 0, 0}));
  geometry::Vector6d twist = geometry::Vector6d::Constant(0.2);
  const JointVector rates = resolved_rates(jacobian, manipulability(jacobian), twist, {});
  ASSERT_TRUE(rates.allFinite());
  // A least-squares solution damped by d is no longer than |twist| / (2 d), rows weighted.
  const RateWeights weights;
  twist.tail<3>() *= weights.rotation;
  EXPECT_LE(rates.norm(), twist.norm() / (2 * weights.damping));
}

TEST(ResolvedRates, DampingComesInWithoutAStep) {
  const ArmModel arm = camera_arm();
  const Jacobian jacobian = arm.camera_jacobian(posture({1.5, -0.9, 1.3, 0.1, 1.0, 0}));
  const geometry::Vector6d twist = geometry::Vector6d::Constant(0.2);
  const RateWeights weights;
  const double least = weights.least_manipulability;
  const JointVector above = resolved_rates(jacobian, least * 1.001, twist, weights);
  const JointVector below = resolved_rates(jacobian, least * 0.999, twist, weights);
  EXPECT_LT((above - below).norm(), 1e-4);
}

}  // namespace
}  // namespace pipescout::manipulation::internal
