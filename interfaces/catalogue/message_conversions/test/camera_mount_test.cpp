// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/camera_mount.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <stdexcept>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using tf2_msgs::msg::TFMessage;

constexpr Time kStart{std::chrono::seconds(1000)};

Time at(double seconds) {
  return kStart + from_seconds(seconds);
}

TFMessage transform(double seconds, const SE3& pose, const char* child = "camera") {
  geometry_msgs::msg::TransformStamped stamped;
  stamped.header.stamp = to_message(at(seconds));
  stamped.header.frame_id = "base_link";
  stamped.child_frame_id = child;
  stamped.transform = transform_message(pose);
  TFMessage message;
  message.transforms.push_back(stamped);
  return message;
}

/// Turns about z and moves up.
SE3 on_arm(double seconds) {
  return {SO3::about_z(0.5 * seconds), {0.1, 0.2, 1 + 0.3 * seconds}};
}

double apart(const SE3& a, const SE3& b) {
  return (a.inverse() * b).log().norm();
}

TEST(CameraMountTest, OneThatDoesNotMoveIsAlwaysThere) {
  CameraMount mount(on_arm(1));
  EXPECT_FALSE(mount.moves());
  mount.add(transform(0, on_arm(2)));
  ASSERT_TRUE(mount.T_base_camera(at(0)));
  EXPECT_LT(apart(*mount.T_base_camera(at(0)), on_arm(1)), 1e-12);
}

TEST(CameraMountTest, OneOnAnArmIsWhereItWasAtThatTime) {
  CameraMount mount("base_link", "camera");
  EXPECT_TRUE(mount.moves());
  EXPECT_FALSE(mount.T_base_camera(at(0)));
  for (int i = 0; i <= 10; ++i) {
    mount.add(transform(0.01 * i, on_arm(0.01 * i)));
  }
  for (const double seconds : {0.0, 0.0537, 0.1, 0.13}) {
    ASSERT_TRUE(mount.T_base_camera(at(seconds))) << seconds;
    EXPECT_LT(apart(*mount.T_base_camera(at(seconds)), on_arm(seconds)), 1e-4) << seconds;
  }
  EXPECT_FALSE(mount.T_base_camera(at(-0.01)));
  EXPECT_FALSE(mount.T_base_camera(at(0.31)));
}

TEST(CameraMountTest, OtherTransformsAreNotItsOwn) {
  CameraMount mount("base_link", "camera");
  mount.add(transform(0, on_arm(0), "gripper"));
  EXPECT_FALSE(mount.T_base_camera(at(0)));
}

TEST(CameraMountTest, ATransformFromBeforeIsLeftOutAndAClockThatWasSetBackBeginsAnew) {
  CameraMount mount("base_link", "camera");
  mount.add(transform(20, on_arm(0)));
  mount.add(transform(19.9, on_arm(5)));
  EXPECT_LT(apart(*mount.T_base_camera(at(20)), on_arm(0)), 1e-12);
  mount.add(transform(1, on_arm(1)));
  EXPECT_FALSE(mount.T_base_camera(at(20)));
  EXPECT_LT(apart(*mount.T_base_camera(at(1)), on_arm(1)), 1e-12);
}

TEST(CameraMountTest, ATransformThatIsNoPoseIsNamed) {
  CameraMount mount("base_link", "camera");
  TFMessage message = transform(0, on_arm(0));
  message.transforms.front().transform.translation.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(mount.add(message), std::invalid_argument);
  message = transform(0, on_arm(0));
  message.transforms.front().transform.rotation.w = 7;
  EXPECT_THROW(mount.add(message), std::invalid_argument);
}

TEST(CameraMountTest, ParametersSayWhichItIs) {
  Parameters fixed;
  EXPECT_FALSE(CameraMountParameters(fixed).read().moves());
  Parameters arm({{.name = "camera.frame", .value = std::string("camera")}});
  EXPECT_TRUE(CameraMountParameters(arm).read().moves());
}

}  // namespace
}  // namespace pipescout
