// SPDX-License-Identifier: Apache-2.0
#include "pipescout/manipulation/arm_model.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace pipescout::manipulation {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

ArmModel camera_arm() {
  return {camera_arm_urdf(), "base_link", "camera_optical_frame"};
}

JointVector posture(std::initializer_list<double> angles) {
  JointVector q(static_cast<Eigen::Index>(angles.size()));
  std::ranges::copy(angles, q.begin());
  return q;
}

JointVector any_posture(const ArmModel& arm) {
  JointVector q(arm.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const ArmJoint& joint = arm.joints()[static_cast<std::size_t>(i)];
    const double share = *rc::gen::inRange(0, 100001) * 1e-5;
    q[i] = joint.lower + share * (joint.upper - joint.lower);
  }
  return q;
}

/// One joint about y at `z` = 1 m, then 2 m of arm with the bodies given.
std::string pendulum(
    const std::string& joint = R"(<limit lower="-2" upper="2" velocity="1" effort="1"/>)",
    const std::string& type = "revolute", const std::string& bodies = "") {
  return R"(<robot name="pendulum"><link name="base"/><link name="aside"/>
    <joint name="swing" type=")" +
         type + R"("><parent link="base"/><child link="rod"/><origin xyz="0 0 1"/>
    <axis xyz="0 1 0"/>)" +
         joint + R"(</joint><link name="rod">)" + bodies + R"(</link>
    <joint name="end" type="fixed"><parent link="rod"/><child link="camera"/>
    <origin xyz="2 0 0"/></joint><link name="camera"/>
    <joint name="other" type="fixed"><parent link="base"/><child link="aside"/></joint></robot>)";
}

std::string refusal(const std::string& urdf, const std::string& base, const std::string& camera) {
  try {
    const ArmModel arm(urdf, base, camera);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(ArmModel, StandsUpWhenAllAnglesAreZero) {
  const ArmModel arm = camera_arm();
  ASSERT_EQ(arm.size(), 6);
  const geometry::SE3 T = arm.T_base_camera(JointVector::Zero(6));
  EXPECT_LT((T.translation() - Vector3d(0.2, 0, 0.3 + 0.2 + 0.4 + 0.4 + 0.08 + 0.06)).norm(), 1e-9);
  EXPECT_LT((T.rotation() * Vector3d::UnitZ() - Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_LT(manipulability(arm.camera_jacobian(JointVector::Zero(6))), 1e-9);
}

TEST(ArmModel, LooksLeftWithTheUpperBorderUp) {
  const ArmModel arm = camera_arm();
  // Shoulder to the left, upper arm leaning back, the camera level.
  const JointVector q = posture({kPi / 2, -0.9, 1.3, 0, kPi / 2 - 0.4, 0});
  const geometry::SE3 T = arm.T_base_camera(q);
  EXPECT_LT((T.rotation() * Vector3d::UnitX() - Vector3d::UnitX()).norm(), 1e-9);
  EXPECT_LT((T.rotation() * Vector3d::UnitY() + Vector3d::UnitZ()).norm(), 1e-9);
  const double out = 0.4 * std::sin(-0.9) + 0.4 * std::sin(0.4) + 0.14;
  const double up = 0.5 + 0.4 * std::cos(0.9) + 0.4 * std::cos(0.4);
  EXPECT_LT((T.translation() - Vector3d(0.2, out, up)).norm(), 1e-9);
}

RC_GTEST_PROP(ArmModel, JacobianIsTheDerivativeOfThePose, ()) {
  const ArmModel arm = camera_arm();
  const JointVector q = any_posture(arm);
  const Jacobian jacobian = arm.camera_jacobian(q);
  constexpr double kStep = 1e-6;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    JointVector ahead = q;
    JointVector back = q;
    ahead[i] += kStep;
    back[i] -= kStep;
    const geometry::Vector6d numeric =
        (arm.T_base_camera(back).inverse() * arm.T_base_camera(ahead)).log() / (2 * kStep);
    RC_ASSERT((numeric - jacobian.col(i)).norm() < 1e-6);
  }
}

TEST(ArmModel, ManipulabilityIsThatOfTheSingularValues) {
  const ArmModel arm = camera_arm();
  const Jacobian jacobian = arm.camera_jacobian(posture({0.3, -0.9, 1.3, 0.2, 1.1, 0.5}));
  const Eigen::MatrixXd dense = jacobian;
  EXPECT_NEAR(manipulability(jacobian), dense.jacobiSvd().singularValues().prod(), 1e-9);
}

TEST(ArmModel, ClearanceOfARodFromGroundAndBase) {
  const std::string rod = R"(<collision><origin xyz="1 0 0" rpy="0 1.5707963267948966 0"/>
    <geometry><cylinder radius="0.1" length="1.8"/></geometry></collision>)";
  const ArmModel arm(
      pendulum(R"(<limit lower="-2" upper="2" velocity="1" effort="1"/>)", "revolute", rod), "base",
      "camera");
  EXPECT_NEAR(arm.clearance(posture({0}), -0.5).plane, 1.5 - 0.1, 1e-9);
  // About +y the rod, along x, goes down.
  EXPECT_NEAR(arm.clearance(posture({kPi / 6}), 0).plane, 1 - 1.9 * 0.5 - 0.1, 1e-9);
  // A link and the one it turns on are not to be kept apart.
  EXPECT_EQ(arm.clearance(posture({0}), 0).self, std::numeric_limits<double>::infinity());
}

TEST(ArmModel, FoldedArmHitsItself) {
  const ArmModel arm = camera_arm();
  EXPECT_GT(arm.clearance(posture({kPi / 2, -0.9, 1.3, 0, 1.0, 0}), -0.35).self, 0.05);
  EXPECT_LT(arm.clearance(posture({0, 0, 2.6, 0, 2.0, 0}), -0.35).self, 0);
  EXPECT_LT(arm.clearance(posture({0, 1.9, 0.8, 0, 0.4, 0}), -0.35).self, 0);
}

TEST(ArmModel, RefusesNamingTheLinkOrJoint) {
  const std::string limit = R"(<limit lower="-2" upper="2" velocity="1" effort="1"/>)";
  const auto names = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_EQ(refusal(pendulum(), "base", "camera"), "");
  EXPECT_TRUE(names(refusal("", "base", "camera"), "urdf"));
  EXPECT_TRUE(names(refusal("<robot", "base", "camera"), "urdf"));
  EXPECT_TRUE(names(refusal("<scene/>", "base", "camera"), "urdf"));
  EXPECT_TRUE(names(refusal(pendulum(), "body", "camera"), "link 'body': is not in"));
  EXPECT_TRUE(names(refusal(pendulum(), "base", "eye"), "link 'eye': is not in"));
  EXPECT_TRUE(names(refusal(pendulum(), "rod", "base"), "link 'base': no chain"));
  EXPECT_TRUE(names(refusal(pendulum(), "aside", "camera"), "link 'camera': no chain"));
  EXPECT_TRUE(names(refusal(pendulum(), "base", "aside"), "0 joints"));
  EXPECT_TRUE(names(refusal(pendulum(""), "base", "camera"), "swing"));
  EXPECT_TRUE(names(refusal(pendulum(limit, "prismatic"), "base", "camera"), "joint 'swing'"));
  EXPECT_TRUE(names(refusal(pendulum(R"(<limit lower="1" upper="1" velocity="1" effort="1"/>)"),
                            "base", "camera"),
                    "joint 'swing': has no position limits"));
  EXPECT_TRUE(names(refusal(pendulum(R"(<limit lower="0" upper="1" velocity="0" effort="1"/>)"),
                            "base", "camera"),
                    "joint 'swing': has no velocity limit"));
  EXPECT_TRUE(names(
      refusal(pendulum(limit, "revolute",
                       R"(<collision><geometry><mesh filename="rod.stl"/></geometry></collision>)"),
              "base", "camera"),
      "link 'rod': a body for collisions is a mesh"));
}

TEST(ArmModel, ContinuousJointsHaveNoLimits) {
  const ArmModel arm(pendulum("", "continuous"), "base", "camera");
  ASSERT_EQ(arm.size(), 1);
  EXPECT_EQ(arm.joints()[0].upper, std::numeric_limits<double>::infinity());
  EXPECT_EQ(arm.joints()[0].lower, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(arm.joints()[0].velocity, 1);
  EXPECT_LT(
      (arm.T_base_camera(posture({kPi / 2 + 4 * kPi})).translation() - Vector3d(0, 0, -1)).norm(),
      1e-9);
  const std::string limited = R"(<limit velocity="0.7" effort="1"/>)";
  EXPECT_EQ(ArmModel(pendulum(limited, "continuous"), "base", "camera").joints()[0].velocity, 0.7);
  EXPECT_EQ(ArmModel(pendulum("", "continuous"), "base", "camera", {.continuous_velocity = 0.2})
                .joints()[0]
                .velocity,
            0.2);
}

TEST(ArmModel, MeshesAreCapsulesBetweenJoints) {
  const std::string mesh =
      R"(<collision><origin xyz="9 9 9"/><geometry><mesh filename="package://a/rod.dae"/></geometry></collision>)";
  const std::string limit = R"(<limit lower="-2" upper="2" velocity="1" effort="1"/>)";
  const ArmModel arm(pendulum(limit, "revolute", mesh), "base", "camera", {.mesh_radius = 0.1});
  EXPECT_NEAR(arm.clearance(posture({0}), 0).plane, 1 - 0.1, 1e-9);
  EXPECT_NEAR(arm.clearance(posture({kPi / 6}), 0).plane, 1 - 2 * 0.5 - 0.1, 1e-9);
  EXPECT_THROW(ArmModel(pendulum(), "base", "camera", {.mesh_radius = -1}), std::invalid_argument);
  EXPECT_THROW(ArmModel(pendulum(), "base", "camera", {.continuous_velocity = 0}),
               std::invalid_argument);
}

TEST(ArmModel, BoxesAreCapsulesAroundThem) {
  const std::string box =
      R"(<collision><origin xyz="1 0 0"/><geometry><box size="2 0.6 0.8"/></geometry></collision>)";
  const std::string limit = R"(<limit lower="-2" upper="2" velocity="1" effort="1"/>)";
  const ArmModel arm(pendulum(limit, "revolute", box), "base", "camera");
  EXPECT_NEAR(arm.clearance(posture({0}), 0).plane, 1 - 0.5, 1e-9);
}

TEST(ArmModel, RefusesWrongAngles) {
  const ArmModel arm = camera_arm();
  EXPECT_THROW((void)arm.T_base_camera(JointVector::Zero(5)), std::invalid_argument);
  EXPECT_THROW((void)arm.camera_jacobian(posture({0, 0, 0, 0, 0, NAN})), std::invalid_argument);
  EXPECT_THROW((void)arm.clearance(JointVector(), 0), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::manipulation
