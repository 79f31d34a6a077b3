// SPDX-License-Identifier: Apache-2.0
#include "pipescout/camera_arm/camera_arm.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::ArmState;
using pipescout_msgs::msg::PipeTrack;
using sensor_msgs::msg::JointState;
using testing::ComponentHarness;
using ::testing::HasSubstr;
using trajectory_msgs::msg::JointTrajectory;

constexpr Time kStart{std::chrono::seconds(1000)};
constexpr Duration kCycle = std::chrono::milliseconds(10);

geometry::CameraParameters camera() {
  return {.width = 320, .height = 240, .focal_length = 720, .centre_u = 159.5, .centre_v = 119.5};
}

class CameraArmTest : public ::testing::Test {
 protected:
  CameraArmTest() { harness_.set_time(kStart); }

  CameraArm& start(const std::vector<NamedParameter>& parameters = {}) {
    auto& arm = harness_.make<CameraArm>({.name = "arm", .parameters = parameters});
    const auto result = harness_.bring_up(arm);
    EXPECT_TRUE(result.success) << result.message;
    send(topics::kThermalCameraInfo, to_message(camera()));
    return arm;
  }

  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }

  [[nodiscard]] JointState joints() const {
    JointState message;
    message.header.stamp = to_message(now_);
    message.name = {"wheel_joint"};
    message.position = {1.0};
    for (std::size_t i = 0; i < position_.size(); ++i) {
      message.name.push_back(model_.joints()[i].name);
      message.position.push_back(position_[i]);
    }
    return message;
  }

  /// In the middle of the picture but `below` px lower.
  [[nodiscard]] PipeTrack track(double below) const {
    PipeTrack message;
    message.header.stamp = to_message(now_);
    message.width = 320;
    message.height = 240;
    message.state = PipeTrack::STATE_LOCKED;
    message.track = 1;
    message.estimate.u = 159.5;
    message.estimate.v = 119.5 + below;
    message.estimate.length = 320;
    message.range = 10;
    return message;
  }

  [[nodiscard]] nav_msgs::msg::Odometry odometry() const {
    nav_msgs::msg::Odometry message;
    message.header.stamp = to_message(now_);
    message.header.frame_id = "map";
    message.child_frame_id = "base_link";
    message.pose.pose = to_message(geometry::SE3());
    message.twist.twist.linear.x = 5.5;
    return message;
  }

  /// Some cycles in which all speak and the arm does what it is told.
  void run(int cycles, double below) {
    for (int i = 0; i < cycles; ++i) {
      tick();
      send(topics::kJointStates, joints());
      send(topics::kOdometryFiltered, odometry());
      if (i % 4 == 0) {
        send(topics::kPipeTrack, track(below));
      }
    }
  }

  void tick() {
    now_ += kCycle;
    harness_.set_time(now_);
    if (!commands_.empty()) {
      position_ = commands_.back().points.at(0).positions;
    }
  }

  [[nodiscard]] std::string counted(const CameraArm& arm, const std::string& key) {
    return harness_.value(harness_.next_diagnostics(arm), key).value_or("none");
  }

  manipulation::ArmModel model_{manipulation::camera_arm_urdf(), "base_link",
                                "camera_optical_frame"};
  std::vector<double> position_ = manipulation::ArmControllerParameters{}.ready;
  Time now_ = kStart;
  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<JointTrajectory> commands_ = harness_.collect(topics::kArmCommand);
  testing::Collector<ArmState> states_ = harness_.collect(topics::kArmState);
  testing::Collector<tf2_msgs::msg::TFMessage> transforms_ = harness_.collect(topics::kTf);
};

TEST_F(CameraArmTest, CommandsOncePerCycleWhileActiveOnly) {
  auto& arm = start();
  run(50, 0);
  EXPECT_NEAR(static_cast<double>(commands_.size()), 50, 2);
  const JointTrajectory& command = commands_.back();
  EXPECT_EQ(command.joint_names.size(), 6U);
  ASSERT_EQ(command.points.size(), 1U);
  EXPECT_EQ(command.points[0].positions.size(), 6U);
  EXPECT_EQ(command.points[0].velocities.size(), 6U);
  EXPECT_EQ(from_message(command.points[0].time_from_start), kCycle);
  EXPECT_EQ(from_message(command.header.stamp), now_);
  EXPECT_EQ(states_.back().state, ArmState::STATE_TRACKING);

  ASSERT_TRUE(harness_.deactivate(arm).success);
  const std::size_t before = commands_.size();
  run(20, 0);
  EXPECT_EQ(commands_.size(), before);
}

TEST_F(CameraArmTest, TurnsTheCameraToThePipe) {
  start();
  run(20, 0);
  const auto pitch = [this] {
    manipulation::JointVector q = Eigen::Map<const Eigen::VectorXd>(position_.data(), 6);
    return model_.T_base_camera(q).rotation().matrix()(2, 2);  // of the view axis, upwards
  };
  const double before = pitch();
  run(30, 30);
  EXPECT_LT(pitch(), before - 1e-3) << "the pipe is below the middle: it looks lower";
  EXPECT_NEAR(states_.back().error_angle, 0, 0.1);
}

TEST_F(CameraArmTest, HoldsInTheCycleInWhichAnInputIsStale) {
  auto& arm = start();
  run(50, 10);
  ASSERT_EQ(states_.back().state, ArmState::STATE_TRACKING);
  // Joints and tracks go on, odometry does not.
  for (int i = 0; i < 15; ++i) {
    tick();
    send(topics::kJointStates, joints());
    send(topics::kPipeTrack, track(10));
    const bool stale = i * 0.01 > 0.1;
    if (stale) {
      EXPECT_EQ(states_.back().state, ArmState::STATE_HOLDING) << i;
    }
  }
  EXPECT_THAT(states_.back().reason, HasSubstr("odometry"));
  EXPECT_EQ(counted(arm, "state"), "holding");
}

TEST_F(CameraArmTest, TellsWhereTheCameraIs) {
  start();
  run(2, 0);
  const auto& transform = transforms_.back().transforms.at(0);
  EXPECT_EQ(transform.header.frame_id, "base_link");
  EXPECT_EQ(transform.child_frame_id, "camera_optical_frame");
  const manipulation::JointVector q = Eigen::Map<const Eigen::VectorXd>(position_.data(), 6);
  EXPECT_TRUE(
      from_message(transform.transform).matrix().isApprox(model_.T_base_camera(q).matrix(), 1e-3));
}

TEST_F(CameraArmTest, StowsWhenItIsToldTo) {
  start();
  run(20, 0);
  std_srvs::srv::SetBool::Request request;
  request.data = true;
  const auto answer = harness_.call<std_srvs::srv::SetBool>("arm/stow", request);
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->success);
  run(5, 0);
  EXPECT_EQ(states_.back().state, ArmState::STATE_STOWING);
}

TEST_F(CameraArmTest, IsNotToldToStowWhileInactive) {
  auto& arm = start();
  run(20, 0);
  ASSERT_TRUE(harness_.deactivate(arm).success);
  std_srvs::srv::SetBool::Request request;
  request.data = true;
  const auto answer = harness_.call<std_srvs::srv::SetBool>("arm/stow", request);
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->success);
  EXPECT_EQ(answer->message, "the component is inactive; activate it first");
  ASSERT_TRUE(harness_.activate(arm).success);
  run(20, 0);
  EXPECT_NE(states_.back().state, ArmState::STATE_STOWING);
}

TEST_F(CameraArmTest, BadInputIsCountedByNameAndNotUsed) {
  auto& arm = start();
  run(20, 0);
  JointState short_of_one = joints();
  short_of_one.name.pop_back();
  send(topics::kJointStates, short_of_one);
  EXPECT_EQ(counted(arm, "joint_states.position.size"), "1");
  tick();
  JointState missing = joints();
  missing.name.back() = "gripper_joint";
  send(topics::kJointStates, missing);
  PipeTrack nonsense = track(0);
  nonsense.estimate.v = std::numeric_limits<double>::quiet_NaN();
  send(topics::kPipeTrack, nonsense);
  PipeTrack other_size = track(0);
  other_size.width = 640;
  send(topics::kPipeTrack, other_size);
  nav_msgs::msg::Odometry turned = odometry();
  turned.pose.pose.orientation.w = 7;
  send(topics::kOdometryFiltered, turned);
  nav_msgs::msg::Odometry elsewhere = odometry();
  elsewhere.header.frame_id = "odom";
  send(topics::kOdometryFiltered, elsewhere);
  const auto status = harness_.next_diagnostics(arm);
  const auto value = [&](const char* key) { return harness_.value(status, key).value_or("none"); };
  EXPECT_EQ(value("joint_states.missing_joint"), "none") << "it may come in another message";
  EXPECT_EQ(value("track.not_a_number"), "1");
  EXPECT_EQ(value("track.other_image_size"), "1");
  EXPECT_EQ(value("odometry.no_rotation"), "1");
  EXPECT_EQ(value("odometry.header.frame_id"), "1");
}

TEST_F(CameraArmTest, AnArmThatIsNotDescribedIsNamed) {
  int number = 0;
  const auto refusal = [&](const std::vector<NamedParameter>& parameters) {
    auto& arm = harness_.make<CameraArm>(
        {.name = "arm_" + std::to_string(number++), .parameters = parameters});
    const auto result = harness_.configure(arm);
    EXPECT_FALSE(result.success);
    return result.message;
  };
  EXPECT_THAT(refusal({{"camera_frame", "gripper"}}), HasSubstr("gripper"));
  EXPECT_THAT(refusal({{"urdf_file", "/nowhere/arm.urdf"}}), HasSubstr("/nowhere/arm.urdf"));
  EXPECT_THAT(refusal({{"centring", "sometimes"}}), HasSubstr("'sometimes' is not one of"));
  EXPECT_THAT(refusal({{"ready", std::vector<double>{0, 0}}}), HasSubstr("ready"));
  const testing::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "arm.urdf";
  std::ofstream(file) << "no description";
  EXPECT_NE(refusal({{"urdf_file", file.string()}}), "");
}

}  // namespace
}  // namespace pipescout
