// SPDX-License-Identifier: Apache-2.0
#include "pipescout/manipulation/robot_tree.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/manipulation/arm_model.hpp"

namespace pipescout::manipulation {
namespace {

using Eigen::Vector3d;
using Names = std::vector<std::string>;
using Positions = std::vector<double>;

/// A mast that rises, a head that turns on it and one that turns half as much the other way.
std::string robot(const std::string& mimicked = "pan") {
  return R"(<robot name="r"><link name="base"/><link name="mast"/><link name="head"/>
    <link name="tail"/><link name="camera"/><link name="drone"/>
    <joint name="lift" type="prismatic"><parent link="base"/><child link="mast"/>
      <origin xyz="1 0 0"/><axis xyz="0 0 2"/>
      <limit lower="0" upper="1" velocity="1" effort="1"/></joint>
    <joint name="pan" type="continuous"><parent link="mast"/><child link="head"/>
      <axis xyz="0 0 1"/></joint>
    <joint name="wag" type="revolute"><parent link="mast"/><child link="tail"/><axis xyz="0 0 1"/>
      <limit lower="-3" upper="3" velocity="1" effort="1"/>
      <mimic joint=")" +
         mimicked + R"(" multiplier="-0.5" offset="0.1"/></joint>
    <joint name="eye" type="fixed"><parent link="head"/><child link="camera"/>
      <origin xyz="0 0.5 0" rpy="0 0 1.5707963267948966"/></joint>
    <joint name="free" type="floating"><parent link="base"/><child link="drone"/></joint></robot>)";
}

TEST(RobotTree, TellsFixedLinksFromThoseThatMove) {
  const RobotTree tree(robot());
  EXPECT_EQ(tree.root(), "base");
  ASSERT_EQ(tree.fixed().size(), 1U);
  EXPECT_EQ(tree.fixed()[0].parent, "head");
  EXPECT_EQ(tree.fixed()[0].child, "camera");
  EXPECT_LT((tree.fixed()[0].T_parent_child * Vector3d(1, 0, 0) - Vector3d(0, 1.5, 0)).norm(),
            1e-12);
  EXPECT_EQ(tree.left_out(), Names{"free"});
}

TEST(RobotTree, MovesTheLinksOfTheNamedJointsAndOfThoseThatMimicThem) {
  const RobotTree tree(robot());
  const auto lifted = tree.moving(Names{"lift", "wheel_of_another"}, Positions{0.25, 7});
  ASSERT_EQ(lifted.size(), 1U);
  EXPECT_EQ(lifted[0].child, "mast");
  EXPECT_LT((lifted[0].T_parent_child.translation() - Vector3d(1, 0, 0.25)).norm(), 1e-12);
  const auto turned = tree.moving(Names{"pan"}, Positions{0.6});
  ASSERT_EQ(turned.size(), 2U);
  EXPECT_EQ(turned[0].child, "head");
  EXPECT_NEAR(turned[0].T_parent_child.rotation().log().z(), 0.6, 1e-12);
  EXPECT_EQ(turned[1].child, "tail");
  EXPECT_NEAR(turned[1].T_parent_child.rotation().log().z(), -0.2, 1e-12);
}

TEST(RobotTree, PutsTheCameraWhereTheArmModelDoes) {
  const RobotTree tree(camera_arm_urdf());
  const ArmModel arm(camera_arm_urdf(), "base_link", "camera_optical_frame");
  Names names;
  JointVector q(arm.size());
  for (Eigen::Index i = 0; i < arm.size(); ++i) {
    names.push_back(arm.joints()[static_cast<std::size_t>(i)].name);
    q[i] = 0.3 - 0.1 * static_cast<double>(i);
  }
  std::vector<LinkTransform> all = tree.moving(names, Positions(q.begin(), q.end()));
  all.insert(all.end(), tree.fixed().begin(), tree.fixed().end());
  geometry::SE3 T_base_camera;
  for (std::string link = "camera_optical_frame"; link != "base_link";) {
    const auto found = std::ranges::find(all, link, &LinkTransform::child);
    ASSERT_NE(found, all.end()) << link;
    T_base_camera = found->T_parent_child * T_base_camera;
    link = found->parent;
  }
  EXPECT_LT((T_base_camera.inverse() * arm.T_base_camera(q)).log().norm(), 1e-9);
}

TEST(RobotTree, WhatIsWrongIsNamed) {
  const auto refusal = [](const auto& attempt) -> std::string {
    try {
      attempt();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal([] { RobotTree("nothing"); }).find("urdf"), std::string::npos);
  EXPECT_EQ(refusal([] { RobotTree(robot("nobody")); }),
            "joint 'wag': mimics joint 'nobody', which is not there");
  const RobotTree tree(robot());
  EXPECT_EQ(refusal([&] { (void)tree.moving(Names{"pan"}, Positions{}); }),
            "1 names of joints and 0 positions");
  EXPECT_EQ(refusal([&] {
              (void)tree.moving(Names{"pan"}, Positions{std::numeric_limits<double>::quiet_NaN()});
            }),
            "the position of joint 'pan' is not finite");
}

}  // namespace
}  // namespace pipescout::manipulation
