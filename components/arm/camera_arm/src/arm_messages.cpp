// SPDX-License-Identifier: Apache-2.0
#include "arm_messages.hpp"

#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {
namespace {

using manipulation::ArmCommand;
using manipulation::ArmJoint;
using manipulation::ArmReason;
using manipulation::ArmState;
using manipulation::InputVerdict;
using manipulation::JointCut;
using manipulation::TrackState;
using pipescout_msgs::msg::PipeTrack;
using ArmStateMessage = pipescout_msgs::msg::ArmState;

TrackState track_state(const pipescout_msgs::msg::PipeTrack& message) {
  switch (message.state) {
    case PipeTrack::STATE_LOCKED:
      // A picture that could not be used shows nothing.
      return message.fault.empty() ? TrackState::kLocked : TrackState::kCoasting;
    case PipeTrack::STATE_COASTING:
      return TrackState::kCoasting;
    case PipeTrack::STATE_LOST:
      return TrackState::kLost;
    default:
      return TrackState::kNone;
  }
}

std::uint8_t to_message(ArmState state) {
  switch (state) {
    case ArmState::kIdle:
      return ArmStateMessage::STATE_IDLE;
    case ArmState::kTracking:
      return ArmStateMessage::STATE_TRACKING;
    case ArmState::kHolding:
      return ArmStateMessage::STATE_HOLDING;
    case ArmState::kSearching:
      return ArmStateMessage::STATE_SEARCHING;
    case ArmState::kStowing:
      return ArmStateMessage::STATE_STOWING;
    case ArmState::kStowed:
      return ArmStateMessage::STATE_STOWED;
    case ArmState::kFault:
      return ArmStateMessage::STATE_FAULT;
  }
  return ArmStateMessage::STATE_FAULT;
}

const char* name(JointCut cut) {
  switch (cut) {
    case JointCut::kPosition:
      return "position";
    case JointCut::kVelocity:
      return "velocity";
    case JointCut::kAcceleration:
      return "acceleration";
    case JointCut::kNone:
      break;
  }
  return "none";
}

}  // namespace

double seconds(const builtin_interfaces::msg::Time& stamp) {
  return to_seconds(from_message(stamp).time_since_epoch());
}

manipulation::PipeSection pipe_section(const pipescout_msgs::msg::PipeTrack& message) {
  return {.time = seconds(message.header.stamp),
          .state = track_state(message),
          .width = static_cast<int>(message.width),
          .height = static_cast<int>(message.height),
          .u = message.estimate.u,
          .v = message.estimate.v,
          .length = message.estimate.length,
          .angle = message.estimate.angle,
          .range = message.range};
}

manipulation::VehicleMotion vehicle_motion(const nav_msgs::msg::Odometry& message) {
  const auto& q = message.pose.pose.orientation;
  const auto& twist = message.twist.twist;
  return {.time = seconds(message.header.stamp),
          .R_map_base = {q.w, q.x, q.y, q.z},
          .velocity = from_message(twist.linear),
          .angular_rate = from_message(twist.angular)};
}

trajectory_msgs::msg::JointTrajectory trajectory_message(const ArmCommand& command,
                                                         const std::vector<ArmJoint>& joints,
                                                         Time stamp, Duration period) {
  trajectory_msgs::msg::JointTrajectory message;
  message.header.stamp = to_message(stamp);
  for (const ArmJoint& joint : joints) {
    message.joint_names.push_back(joint.name);
  }
  trajectory_msgs::msg::JointTrajectoryPoint point;
  point.positions.assign(command.position.begin(), command.position.end());
  point.velocities.assign(command.velocity.begin(), command.velocity.end());
  point.time_from_start = to_message(period);
  message.points.push_back(std::move(point));
  return message;
}

pipescout_msgs::msg::ArmState state_message(const ArmCommand& command,
                                            const std::vector<ArmJoint>& joints) {
  pipescout_msgs::msg::ArmState message;
  message.state = to_message(command.state);
  message.reason = command.reason == ArmReason::kNone ? "" : to_string(command.reason);
  message.error_u = command.error_u;
  message.error_v = command.error_v;
  message.error_angle = command.error_angle;
  message.feed_forward = command.feed_forward;
  message.manipulability = command.manipulability;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (command.cuts.at(i) != JointCut::kNone) {
      message.limited.push_back(joints[i].name + " " + name(command.cuts.at(i)));
    }
  }
  if (command.clearance_cut) {
    message.limited.emplace_back("clearance");
  }
  return message;
}

std::string counter(const std::string& input, InputVerdict verdict) {
  switch (verdict) {
    case InputVerdict::kNotANumber:
      return input + ".not_a_number";
    case InputVerdict::kNoRotation:
      return input + ".no_rotation";
    case InputVerdict::kFromTheFuture:
      return input + ".header.stamp.in_future";
    case InputVerdict::kStale:
      return input + ".header.stamp.stale";
    case InputVerdict::kOutOfOrder:
      return input + ".header.stamp.not_increasing";
    case InputVerdict::kOtherImageSize:
      return input + ".other_image_size";
    case InputVerdict::kTaken:
    case InputVerdict::kPartial:
    case InputVerdict::kOfOthers:
      break;
  }
  return input + ".taken";
}

}  // namespace pipescout
