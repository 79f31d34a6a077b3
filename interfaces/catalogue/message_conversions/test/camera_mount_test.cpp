// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/camera_mount.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/runtime/transform_broadcaster.hpp"

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using ::testing::HasSubstr;

constexpr Time kStart{std::chrono::seconds(1000)};

Time at(double seconds) {
  return kStart + from_seconds(seconds);
}

geometry_msgs::msg::TransformStamped transform(double seconds, const SE3& pose,
                                               const char* parent = "base_link",
                                               const char* child = "camera") {
  geometry_msgs::msg::TransformStamped stamped;
  stamped.header.stamp = to_message(at(seconds));
  stamped.header.frame_id = parent;
  stamped.child_frame_id = child;
  stamped.transform = transform_message(pose);
  return stamped;
}

/// Turns about z and moves up.
SE3 on_arm(double seconds) {
  return {SO3::about_z(0.5 * seconds), {0.1, 0.2, 1 + 0.3 * seconds}};
}

double apart(const SE3& a, const SE3& b) {
  return (a.inverse() * b).log().norm();
}

class CameraMountTest : public ::testing::Test {
 protected:
  std::string missing(const CameraMount& mount, double seconds) const {
    std::string why;
    EXPECT_FALSE(mount.T_base_camera(at(seconds), &why));
    return why;
  }

  Executor executor_;
  Node node_{
      {.context = Context::create_in_process(), .executor = &executor_, .name = {"/", "robot"}}};
  TransformBroadcaster moving_{node_};
  CameraMount mount_{node_.transforms(), "base_link", "camera"};
};

TEST_F(CameraMountTest, OneThatDoesNotMoveIsAlwaysThere) {
  const CameraMount mount(on_arm(1));
  EXPECT_FALSE(mount.moves());
  ASSERT_TRUE(mount.T_base_camera(at(0)));
  EXPECT_LT(apart(*mount.T_base_camera(at(0)), on_arm(1)), 1e-12);
}

TEST_F(CameraMountTest, OneOnAnArmIsWhereItWasAtThatTime) {
  EXPECT_TRUE(mount_.moves());
  EXPECT_THAT(missing(mount_, 0), HasSubstr("frame 'camera' is not known"));
  for (int i = 0; i <= 10; ++i) {
    moving_.send(transform(0.01 * i, on_arm(0.01 * i)));
  }
  for (const double seconds : {0.0, 0.0537, 0.1, 0.13}) {
    ASSERT_TRUE(mount_.T_base_camera(at(seconds))) << seconds;
    EXPECT_LT(apart(*mount_.T_base_camera(at(seconds)), on_arm(seconds)), 1e-4) << seconds;
  }
  EXPECT_THAT(missing(mount_, -0.01), HasSubstr("'camera' in 'base_link' is known from"));
  EXPECT_THAT(missing(mount_, 0.31), HasSubstr("asked for 1000.31"));
}

TEST_F(CameraMountTest, NothingIsSaidOfALongGap) {
  moving_.send({transform(0, on_arm(0)), transform(0.5, on_arm(0.5))});
  EXPECT_THAT(missing(mount_, 0.25), HasSubstr("lie 0.5 s apart"));
  EXPECT_TRUE(mount_.T_base_camera(at(0.5)));
}

// geometry2#46: the joint on tf, what is fixed to it on tf_static, as robot_state_publisher sends
// them.
TEST_F(CameraMountTest, AChainOverBothTopicsIsComposedAndAMissingLinkIsNamed) {
  const SE3 T_pan_camera(SO3(), {0, 0, 0.1});
  StaticTransformBroadcaster fixed(node_);
  fixed.send(transform(0, T_pan_camera, "pan_link", "camera"));
  EXPECT_THAT(missing(mount_, 0), HasSubstr("frame 'base_link' is not known"));
  moving_.send({transform(0, on_arm(0), "base_link", "pan_link"),
                transform(0.1, on_arm(0.1), "base_link", "pan_link")});
  ASSERT_TRUE(mount_.T_base_camera(at(0.05)));
  EXPECT_LT(apart(*mount_.T_base_camera(at(0.05)), on_arm(0.05) * T_pan_camera), 1e-4);
  EXPECT_LT(apart(*mount_.T_base_camera(at(0.15)), on_arm(0.15) * T_pan_camera), 1e-4);
}

TEST_F(CameraMountTest, ParametersSayWhichItIs) {
  const auto moves = [this](std::vector<ParameterOverride> overrides) {
    Parameters parameters(std::move(overrides));
    return CameraMountParameters(parameters).read(node_).moves();
  };
  EXPECT_FALSE(moves({}));
  EXPECT_TRUE(moves({{.name = "camera.frame", .value = std::string("camera")}}));
}

}  // namespace
}  // namespace pipescout
