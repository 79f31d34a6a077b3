// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/msg/arm_state.hpp>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <trajectory_msgs/msg/joint_trajectory.hpp>

#include "pipescout/camera_arm/arm_settings.hpp"
#include "pipescout/manipulation/arm_controller.hpp"
#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// Controls an arm that keeps a pipe in view of its camera: `joint_states`, `track/pipe`,
/// `odometry/filtered` and `thermal/camera_info` in, `arm/command` and `arm/state` out in each
/// cycle while active, and the pose of the camera on `/tf`. Services `~/stow` and `~/reset`.
///
/// Parameters, states and faults: docs/components/camera_arm.md. Parameters take effect when it is
/// configured.
class CameraArm final : public Component {
 public:
  explicit CameraArm(ComponentOptions options);
  ~CameraArm() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_activate() override;
  CallbackReturn on_cleanup() override;

 private:
  using ArmState = pipescout_msgs::msg::ArmState;
  using CameraInfo = sensor_msgs::msg::CameraInfo;
  using JointState = sensor_msgs::msg::JointState;
  using JointTrajectory = trajectory_msgs::msg::JointTrajectory;
  using Odometry = nav_msgs::msg::Odometry;
  using PipeTrack = pipescout_msgs::msg::PipeTrack;
  using TFMessage = tf2_msgs::msg::TFMessage;
  using SetBool = std_srvs::srv::SetBool;
  using Trigger = std_srvs::srv::Trigger;

  /// Services take requests while active only; else `refusal` says so.
  [[nodiscard]] bool is_commandable(std::string& refusal) const;
  /// The inputs are subscribed to when enough subscriptions of the outputs are matched.
  void subscribe();
  void on_joint_states(const JointState& message);
  void on_track(const PipeTrack& message);
  void on_odometry(const Odometry& message);
  void on_camera_info(const CameraInfo& message);
  void count(const char* input, manipulation::InputVerdict verdict);
  void publish_transform(const builtin_interfaces::msg::Time& last);
  void cycle();
  void tell(const manipulation::ArmCommand& command);

  ArmParameters declared_;
  AwaitedSubscribers awaited_{
      *this, "the component subscribes to its inputs", {"command", "state"}};

  // As configured.
  std::optional<ArmSettings> settings_;

  std::optional<manipulation::ArmController> controller_;
  std::optional<CameraInfo> calibration_;
  manipulation::ArmRequest request_ = manipulation::ArmRequest::kTrack;
  std::optional<manipulation::ArmCommand> told_;  // reported on /diagnostics and in the log
  std::uint64_t cycles_ = 0;

  Publisher<JointTrajectory> command_publisher_;
  Publisher<ArmState> state_publisher_;
  Publisher<TFMessage> tf_publisher_;
  Subscription<JointState> joint_subscription_;
  Subscription<PipeTrack> track_subscription_;
  Subscription<Odometry> odometry_subscription_;
  Subscription<CameraInfo> camera_info_subscription_;
  Service<SetBool> stow_service_;
  Service<Trigger> reset_service_;
  std::shared_ptr<Timer> cycle_timer_;
};

}  // namespace pipescout
