// SPDX-License-Identifier: Apache-2.0
// Joints of the arm in several messages, among those of other devices.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pipescout/manipulation/arm_controller.hpp"

namespace pipescout::manipulation {
namespace {

class JointMessages : public ::testing::Test {
 protected:
  JointMessages()
      : controller_(ArmModel(camera_arm_urdf(), "base_link", "camera_optical_frame"), {}) {
    for (const ArmJoint& joint : controller_.model().joints()) {
      names_.push_back(joint.name);
    }
  }

  /// Joints `first` to `last` - 1 of the arm, each at this position.
  InputVerdict send(std::size_t first, std::size_t last, double time, double position,
                    ArmController* controller = nullptr) {
    const std::vector<std::string> names(names_.begin() + static_cast<std::ptrdiff_t>(first),
                                         names_.begin() + static_cast<std::ptrdiff_t>(last));
    const std::vector<double> positions(names.size(), position);
    return (controller != nullptr ? *controller : controller_)
        .observe({.time = time, .names = names, .positions = positions}, time);
  }

  std::vector<std::string> names_;
  ArmController controller_;
};

TEST_F(JointMessages, AreMergedAtTheTimeThatAllHave) {
  EXPECT_EQ(controller_.unseen_joints(), names_);
  EXPECT_EQ(send(0, 2, 10.00, 0.1), InputVerdict::kPartial);
  EXPECT_EQ(controller_.unseen_joints().size(), 4U);
  EXPECT_FALSE(controller_.joints().has_value());
  EXPECT_EQ(send(2, 6, 10.004, 0.2), InputVerdict::kTaken);
  EXPECT_TRUE(controller_.unseen_joints().empty());
  EXPECT_DOUBLE_EQ(controller_.joints()->first, 10.00);
  // Up to 10.004 all are known, the first two between their readings.
  EXPECT_EQ(send(0, 2, 10.01, 0.2), InputVerdict::kTaken);
  EXPECT_DOUBLE_EQ(controller_.joints()->first, 10.004);
  EXPECT_NEAR(controller_.joints()->second[0], 0.14, 1e-9);
  EXPECT_DOUBLE_EQ(controller_.joints()->second[5], 0.2);
  EXPECT_EQ(send(0, 2, 10.011, 0.2), InputVerdict::kPartial);
  EXPECT_EQ(send(0, 2, 10.011, 0.2), InputVerdict::kOutOfOrder);
}

TEST_F(JointMessages, AnArmInTwoMessagesBecomesActive) {
  ArmCommand command;
  for (int i = 0; i < 20; ++i) {
    const double now = 10 + 0.01 * i;
    for (std::size_t k = 0; k < names_.size(); ++k) {
      EXPECT_NE(send(k, k + 1, now, controller_.parameters().ready[k]), InputVerdict::kOutOfOrder);
    }
    command = controller_.step(now, ArmRequest::kTrack);
  }
  EXPECT_EQ(command.reason, ArmReason::kNoIntrinsics);
  EXPECT_TRUE(command.commanded);
}

TEST_F(JointMessages, OfOtherDevicesArePassedOver) {
  const std::vector<std::string> names{"left_wheel_joint", "right_wheel_joint"};
  const std::vector<double> positions{NAN, 700};
  EXPECT_EQ(controller_.observe({.time = 10, .names = names, .positions = positions}, 10),
            InputVerdict::kOfOthers);
  EXPECT_EQ(send(0, 6, 10, 0.1), InputVerdict::kTaken);
}

TEST_F(JointMessages, OneThatStopsMakesAllStale) {
  EXPECT_EQ(send(0, 2, 10, 0.1), InputVerdict::kPartial);
  EXPECT_EQ(send(2, 6, 10, 0.1), InputVerdict::kTaken);
  for (int i = 1; i < 30; ++i) {
    EXPECT_EQ(send(0, 2, 10 + 0.01 * i, 0.1), InputVerdict::kPartial);
  }
  EXPECT_EQ(controller_.step(10.3, ArmRequest::kTrack).reason, ArmReason::kStaleJointReadings);
}

/// The six-joint arm with a first joint that has no limits.
std::string continuous_arm() {
  std::string urdf(camera_arm_urdf());
  const auto joint = urdf.find("\"shoulder_pan_joint\"");
  const auto type = urdf.find("revolute", joint);
  return urdf.replace(type, std::string("revolute").size(), "continuous");
}

TEST_F(JointMessages, ContinuousJointsMayCountTurnsOrNot) {
  constexpr double kTurn = 2 * std::numbers::pi;
  ArmController controller(ArmModel(continuous_arm(), "base_link", "camera_optical_frame"), {});
  std::vector<double> positions = controller.parameters().ready;
  double angle = positions[0];
  double now = 10;
  ArmCommand command;
  for (int i = 0; i < 400; ++i, now += 0.01, angle += 0.02) {
    positions[0] = std::remainder(angle, kTurn);  // as one that does not
    ASSERT_EQ(controller.observe({.time = now, .names = names_, .positions = positions}, now),
              InputVerdict::kTaken);
    EXPECT_NEAR(controller.joints()->second[0], angle, 1e-9);
  }
  command = controller.step(now, ArmRequest::kStow);
  EXPECT_EQ(command.state, ArmState::kStowing);
  EXPECT_TRUE(command.position.allFinite());
}

}  // namespace
}  // namespace pipescout::manipulation
