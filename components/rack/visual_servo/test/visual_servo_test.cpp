// SPDX-License-Identifier: Apache-2.0
#include "pipescout/visual_servo/visual_servo.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <utility>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;
using pipescout_msgs::msg::MissionStatus;
using pipescout_msgs::msg::RackState;
using testing::Collector;
using testing::ComponentHarness;
using ::testing::HasSubstr;

using Pose = geometry_msgs::msg::PoseWithCovarianceStamped;
using State = pipescout_msgs::msg::RackState;
using Twist = geometry_msgs::msg::TwistStamped;

constexpr Duration kFrame = std::chrono::milliseconds(40);
constexpr Time kStart{std::chrono::seconds(1000)};

std::vector<NamedParameter> two_way_points(std::vector<NamedParameter> extra = {}) {
  extra.push_back({"way_points", std::vector<double>{1, 5, 3, 0, 1, 5.5, 3, 0.1}});
  extra.push_back({"hold", 0.5});
  return extra;
}

Pose pose_message(Time stamp, const SE3& T_rack_base) {
  const SE3 T_rack_camera = T_rack_base * rack_vision::downward_camera();
  Pose message;
  message.header.stamp = to_message(stamp);
  message.header.frame_id = "rack";
  auto& pose = message.pose.pose;
  pose.position.x = T_rack_camera.translation().x();
  pose.position.y = T_rack_camera.translation().y();
  pose.position.z = T_rack_camera.translation().z();
  const Eigen::Quaterniond q = T_rack_camera.rotation().quaternion();
  pose.orientation.w = q.w();
  pose.orientation.x = q.x();
  pose.orientation.y = q.y();
  pose.orientation.z = q.z();
  return message;
}

State state_message(Time stamp, std::uint8_t status, double quality) {
  State message;
  message.header.stamp = to_message(stamp);
  message.header.frame_id = "rack";
  message.status = status;
  message.quality = quality;
  return message;
}

/// A servo and a robot that does at once what it is told.
class VisualServoTest : public ::testing::Test {
 protected:
  void bring_up(std::vector<NamedParameter> parameters = two_way_points()) {
    servo_ = &harness_.make<VisualServo>({.parameters = std::move(parameters)});
    commands_ = harness_.collect(topics::kVelocityCommand);
    progress_ = harness_.collect(topics::kMissionStatus);
    harness_.set_time(now_);
    const auto result = harness_.bring_up(*servo_);
    ASSERT_TRUE(result.success) << result.message;
  }

  void next_frame() {
    now_ += kFrame;
    harness_.set_time(now_);
  }

  void send_pose() {
    harness_.publish(topics::kRackPose, pose_message(now_, T_rack_base_));
    harness_.publish(topics::kRackState, state_message(now_, RackState::STATUS_TRACKING, 0.9));
    harness_.spin();
  }

  void obey() {
    const auto& twist = commands_.back().twist;
    geometry::Vector6d motion;
    motion << twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.x, twist.angular.y,
        twist.angular.z;
    T_rack_base_ = T_rack_base_ * SE3::exp(motion * to_seconds(kFrame));
  }

  [[nodiscard]] double speed() const {
    const auto& linear = commands_.back().twist.linear;
    return Vector3d(linear.x, linear.y, linear.z).norm();
  }

  ComponentHarness harness_{{.simulated_time = true}};
  VisualServo* servo_ = nullptr;
  Collector<Twist> commands_;
  Collector<MissionStatus> progress_;
  Time now_ = kStart;
  SE3 T_rack_base_{SO3::about_z(0.2), {1.2, 4.8, 2.9}};
};

TEST_F(VisualServoTest, ReachesNoWayPointByAPoseThatIsNotKnownSoWell) {
  bring_up();
  T_rack_base_ = SE3(SO3(), {1, 5, 3});
  const auto stay = [this](const std::array<double, 36>& covariance) {
    for (int i = 0; i < 50; ++i) {
      next_frame();
      Pose message = pose_message(now_, T_rack_base_);
      message.pose.covariance = covariance;
      harness_.publish(topics::kRackPose, message);
      harness_.spin();
    }
  };
  const auto known_to = [](double position, double yaw) {
    std::array<double, 36> covariance{};
    for (std::size_t i = 0; i < 6; ++i) {
      covariance[7 * i] = 1e-6;
    }
    covariance[7] = position * position;
    covariance[35] = yaw * yaw;
    return covariance;
  };
  stay(known_to(0.016, 0.001));
  EXPECT_TRUE(progress_.empty());
  stay(known_to(0.001, 0.01));
  EXPECT_TRUE(progress_.empty());
  std::array<double, 36> broken = known_to(0.001, 0.001);
  broken[0] = -1;
  stay(broken);
  EXPECT_TRUE(progress_.empty());
  EXPECT_EQ(servo_->diagnostics().counter("pose.covariance"), 50U);
  stay(known_to(0.014, 0.001));
  ASSERT_FALSE(progress_.empty());
  EXPECT_THAT(progress_.back().message, HasSubstr("1 of 2 way-points reached"));
}

TEST_F(VisualServoTest, FliesAlongTheWayPointsAndSaysSo) {
  bring_up();
  for (int i = 0;
       i < 1000 && (progress_.empty() || progress_.back().state != MissionStatus::COMPLETE); ++i) {
    next_frame();
    send_pose();
    ASSERT_EQ(from_message(commands_.back().header.stamp), now_);
    obey();
  }
  ASSERT_FALSE(progress_.empty());
  EXPECT_EQ(progress_.back().state, MissionStatus::COMPLETE);
  EXPECT_EQ(progress_.at(progress_.size() - 2).done, 2U);
  EXPECT_EQ(progress_.at(progress_.size() - 2).total, 2U);
  EXPECT_THAT(progress_.back().message, HasSubstr("2 of 2 way-points reached, 0 missed"));
  EXPECT_EQ(commands_.back().header.frame_id, "base_stabilized");
  EXPECT_LT((T_rack_base_.translation() - Vector3d(1, 5.5, 3)).norm(), 0.03);
  // It stays there.
  for (int i = 0; i < 50; ++i) {
    next_frame();
    send_pose();
    obey();
  }
  EXPECT_LT((T_rack_base_.translation() - Vector3d(1, 5.5, 3)).norm(), 0.005);
}

TEST_F(VisualServoTest, HoldsAndClimbsWithoutAPoseAndWarns) {
  bring_up(two_way_points({{"hold_time", 1.0}, {"climb.height", 0.5}}));
  T_rack_base_ = SE3(SO3(), {0, 5, 3});
  for (int i = 0; i < 50; ++i) {
    next_frame();
    send_pose();
  }
  EXPECT_NEAR(speed(), 0.5, 1e-9);
  const std::size_t before = commands_.size();
  double climbed = 0;
  double highest = 0;
  for (int i = 0; i < 60; ++i) {
    harness_.advance(std::chrono::milliseconds(100));
    climbed += commands_.back().twist.linear.z * 0.1;
    highest = std::max(highest, commands_.back().twist.linear.z);
  }
  // The timer keeps commanding, ten times a second.
  EXPECT_NEAR(static_cast<double>(commands_.size() - before), 60, 2);
  EXPECT_NEAR(highest, 0.3, 1e-9);
  EXPECT_NEAR(climbed, 0.5, 0.1);
  EXPECT_LT(speed(), 1e-9);
  const auto diagnostics = harness_.next_diagnostics(*servo_);
  EXPECT_EQ(diagnostics.level, diagnostic_msgs::msg::DiagnosticStatus::WARN);
  EXPECT_THAT(diagnostics.message, HasSubstr("no pose"));
}

TEST_F(VisualServoTest, AnswersImagesWithoutAPoseToo) {
  bring_up();
  next_frame();
  send_pose();
  const std::size_t before = commands_.size();
  next_frame();
  harness_.publish(topics::kRackState, state_message(now_, RackState::STATUS_LOST, 0));
  harness_.spin();
  EXPECT_EQ(commands_.size(), before + 1);
  EXPECT_EQ(from_message(commands_.back().header.stamp), now_);
  // Found again: the pose counts before its own state has come.
  next_frame();
  harness_.publish(topics::kRackPose, pose_message(now_, T_rack_base_));
  harness_.spin();
  EXPECT_EQ(commands_.size(), before + 2);
  EXPECT_EQ(servo_->diagnostics().counter("pose.low_quality"), 0U);
}

TEST_F(VisualServoTest, CommandsZeroWhenDeactivatedAndGoesOnAfterwards) {
  bring_up();
  for (int i = 0; i < 20; ++i) {
    next_frame();
    send_pose();
  }
  EXPECT_GT(speed(), 0.1);
  ASSERT_TRUE(harness_.deactivate(*servo_).success);
  harness_.spin();
  EXPECT_EQ(speed(), 0);
  const std::size_t before = commands_.size();
  next_frame();
  send_pose();
  EXPECT_EQ(commands_.size(), before);
  ASSERT_TRUE(harness_.activate(*servo_).success);
  for (int i = 0; i < 20; ++i) {
    next_frame();
    send_pose();
  }
  EXPECT_GT(speed(), 0.1);
}

TEST_F(VisualServoTest, CountsWhatItDoesNotUse) {
  bring_up();
  next_frame();
  send_pose();
  const std::size_t before = commands_.size();
  const auto send = [&](Pose message) {
    harness_.publish(topics::kRackPose, std::move(message));
    harness_.spin();
  };
  send(pose_message(now_, T_rack_base_));
  send(pose_message(now_ - std::chrono::seconds(1), T_rack_base_));
  send(pose_message(now_ + std::chrono::seconds(1), T_rack_base_));
  Pose message = pose_message(now_ + std::chrono::milliseconds(1), T_rack_base_);
  message.pose.pose.position.x = std::numeric_limits<double>::quiet_NaN();
  send(message);
  message = pose_message(now_ + std::chrono::milliseconds(1), T_rack_base_);
  message.pose.pose.orientation.w = 3;
  send(message);
  message = pose_message(now_ + std::chrono::milliseconds(1), T_rack_base_);
  message.header.frame_id = "map";
  send(message);
  harness_.publish(topics::kRackState, state_message(now_, RackState::STATUS_TRACKING, 0.1));
  harness_.spin();
  send(pose_message(now_ + std::chrono::milliseconds(1), T_rack_base_));
  harness_.publish(topics::kRackState, state_message(now_, RackState::STATUS_TRACKING, 7));
  harness_.spin();
  // Only the image whose pose was not good enough is answered.
  EXPECT_EQ(commands_.size(), before + 1);
  for (const char* counter :
       {"pose.header.stamp.not_increasing", "pose.header.stamp.stale",
        "pose.header.stamp.in_future", "pose.not_a_number", "pose.no_rotation",
        "pose.header.frame_id", "pose.low_quality", "state.quality"}) {
    EXPECT_EQ(servo_->diagnostics().counter(counter), 1U) << counter;
  }
}

TEST_F(VisualServoTest, IsCompleteAfterTheHoldAtAWayPointThatWasReachedBefore) {
  bring_up(two_way_points({{"reached_for", 0.1}}));
  const auto complete = [this] {
    return !progress_.empty() && progress_.back().state == MissionStatus::COMPLETE;
  };
  std::optional<Time> reached;
  for (int i = 0; i < 1000 && !complete(); ++i) {
    next_frame();
    send_pose();
    obey();
    if (!reached && !progress_.empty() && progress_.back().done == 2U) {
      reached = now_;
    }
  }
  ASSERT_TRUE(complete());
  ASSERT_TRUE(reached);
  EXPECT_GT(now_ - *reached, std::chrono::milliseconds(300)) << "of the 0.5 s that it holds";
  const std::size_t said = progress_.size();
  next_frame();
  send_pose();
  EXPECT_EQ(progress_.size(), said) << "once";
}

TEST_F(VisualServoTest, BeginsAgainWithTheClock) {
  bring_up();
  for (int i = 0;
       i < 1000 && (progress_.empty() || progress_.back().state != MissionStatus::COMPLETE); ++i) {
    next_frame();
    send_pose();
    obey();
  }
  ASSERT_FALSE(progress_.empty());
  EXPECT_EQ(progress_.back().state, MissionStatus::COMPLETE);
  now_ = Time(std::chrono::seconds(10));
  T_rack_base_ = SE3(SO3(), {1, 5, 3});
  progress_.clear();
  for (int i = 0;
       i < 1000 && (progress_.empty() || progress_.back().state != MissionStatus::COMPLETE); ++i) {
    next_frame();
    send_pose();
    obey();
  }
  ASSERT_FALSE(progress_.empty());
  EXPECT_EQ(progress_.at(0).done, 1U);
  EXPECT_EQ(progress_.back().state, MissionStatus::COMPLETE);
}

TEST_F(VisualServoTest, UsesNoPoseUntilTransformsTellWhereTheCameraIs) {
  bring_up(two_way_points({{"camera.frame", "gimbal"}}));
  next_frame();
  send_pose();
  EXPECT_EQ(servo_->diagnostics().counter("tf.missing"), 1U);
  EXPECT_TRUE(commands_.empty());

  // The camera sits 0.3 m ahead of the origin: at the first way-point it is seen ahead of it.
  const SE3 T_base_camera = rack_vision::downward_camera({0.3, 0, 0});
  const auto mounted = to_message(T_base_camera);
  tf2_msgs::msg::TFMessage tf;
  auto& transform = tf.transforms.emplace_back();
  transform.header.stamp = to_message(now_);
  transform.header.frame_id = "base_link";
  transform.child_frame_id = "gimbal";
  transform.transform.translation.x = mounted.position.x;
  transform.transform.translation.y = mounted.position.y;
  transform.transform.translation.z = mounted.position.z;
  transform.transform.rotation = mounted.orientation;
  harness_.publish(topics::kTfStatic, tf);
  harness_.spin();

  T_rack_base_ = SE3(SO3(), {1.3, 5, 3});
  next_frame();
  send_pose();
  EXPECT_EQ(servo_->diagnostics().counter("tf.missing"), 1U);
  EXPECT_LT(speed(), 1e-9);
}

std::string refusal(std::vector<NamedParameter> parameters) {
  ComponentHarness harness;
  auto& servo = harness.make<VisualServo>({.parameters = std::move(parameters)});
  const auto result = harness.configure(servo);
  EXPECT_FALSE(result.success);
  return result.message;
}

TEST(VisualServoParametersOfTheComponent, NameWhatIsWrong) {
  EXPECT_THAT(refusal({}), HasSubstr("'way_points' has 0 values"));
  EXPECT_THAT(refusal({{"way_points", std::vector<double>{1, 2, 3}}}),
              HasSubstr("'way_points' has 3 values"));
  EXPECT_THAT(refusal({{"way_points", std::vector<double>{1, 2, 3, std::nan("")}}}),
              HasSubstr("way_points[0].yaw"));
  EXPECT_THAT(refusal(two_way_points({{"path.largest_speed", 0.0}})), HasSubstr("largest_speed"));
  EXPECT_THAT(refusal(two_way_points({{"tolerance.position", -1.0}})),
              HasSubstr("tolerance.position: -1"));
  EXPECT_THAT(refusal(two_way_points({{"climb.speed", 2.0}})), HasSubstr("climb_speed: 2"));
  EXPECT_THAT(refusal(two_way_points({{"camera.position", std::vector<double>{1, 2}}})),
              HasSubstr("'camera.position' must be empty or three"));
}

}  // namespace
}  // namespace pipescout
