// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nav_msgs/msg/odometry.hpp>
#include <pipescout_msgs/msg/arm_state.hpp>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <string>
#include <trajectory_msgs/msg/joint_trajectory.hpp>
#include <vector>

#include "pipescout/manipulation/arm_controller.hpp"
#include "pipescout/runtime/time.hpp"

/// Between messages and what the controller takes and gives. All functions are pure.
namespace pipescout {

/// s since the epoch of `Time`.
[[nodiscard]] double seconds(const builtin_interfaces::msg::Time& stamp);

/// Numbers are as they are: the controller refuses those that are none.
[[nodiscard]] manipulation::PipeSection pipe_section(const pipescout_msgs::msg::PipeTrack& message);
[[nodiscard]] manipulation::VehicleMotion vehicle_motion(const nav_msgs::msg::Odometry& message);

/// To be there one `period` after `stamp`.
[[nodiscard]] trajectory_msgs::msg::JointTrajectory trajectory_message(
    const manipulation::ArmCommand& command, const std::vector<manipulation::ArmJoint>& joints,
    Time stamp, Duration period);

/// All but the header.
[[nodiscard]] pipescout_msgs::msg::ArmState state_message(
    const manipulation::ArmCommand& command, const std::vector<manipulation::ArmJoint>& joints);

/// What an input that is not taken counts as: "joint_states.not_a_number".
[[nodiscard]] std::string counter(const std::string& input, manipulation::InputVerdict verdict);

}  // namespace pipescout
