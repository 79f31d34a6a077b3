// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/camera_mount.hpp"

#include <utility>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/mounting_parameters.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {
namespace {

constexpr std::size_t kTransforms = 500;  // that are kept: 5 s of an arm at 100 Hz
constexpr double kReach = 0.2;            // s

}  // namespace

CameraMount::CameraMount(const geometry::SE3& T_base_camera)
    : fixed_(T_base_camera), history_(1, kReach) {}

CameraMount::CameraMount(std::string base_frame, std::string camera_frame)
    : base_frame_(std::move(base_frame)),
      camera_frame_(std::move(camera_frame)),
      history_(kTransforms, kReach) {}

void CameraMount::add(const tf2_msgs::msg::TFMessage& message) {
  if (fixed_) {
    return;
  }
  for (const auto& transform : message.transforms) {
    if (transform.header.frame_id != base_frame_ || transform.child_frame_id != camera_frame_) {
      continue;
    }
    OdometryHistory::Entry entry{.time = from_message(transform.header.stamp),
                                 .T_odom_base = from_message(transform.transform),
                                 .twist = geometry::Vector6d::Zero()};
    if (last_ && entry.time > last_->time) {
      const double since = to_seconds(entry.time - last_->time);
      if (since < kReach) {
        entry.twist = (last_->T_odom_base.inverse() * entry.T_odom_base).log() / since;
      }
    }
    if (history_.add(entry)) {
      last_ = entry;
    }
  }
}

std::optional<geometry::SE3> CameraMount::T_base_camera(Time time) const {
  return fixed_ ? fixed_ : history_.at(time);
}

CameraMountParameters::CameraMountParameters(Parameters& parameters) {
  position_ = parameters.declare<std::vector<double>>(
      "camera.position", {},
      {.description = "m, x y z of the camera in the base frame of odometry; empty: 0 0 0"});
  roll_pitch_yaw_ = parameters.declare<std::vector<double>>(
      "camera.roll_pitch_yaw", {},
      {.description = "rad, of the optical frame in the base frame; empty: looks straight down, "
                      "the upper border of the image forward"});
  camera_frame_ = parameters.declare<std::string>(
      "camera.frame", "",
      {.description = "frame on /tf, relative to base_frame, of a camera that moves on the robot; "
                      "empty: the camera is fixed at camera.position and camera.roll_pitch_yaw"});
  base_frame_ = parameters.declare<std::string>(
      "base_frame", "base_link",
      {.description = "base frame of the robot, parent of camera.frame"});
}

geometry::SE3 CameraMountParameters::T_base_camera() const {
  return camera_mounting(position_, roll_pitch_yaw_);
}

CameraMount CameraMountParameters::read() const {
  const std::string camera_frame = camera_frame_.get();
  return camera_frame.empty() ? CameraMount(T_base_camera())
                              : CameraMount(base_frame_.get(), camera_frame);
}

}  // namespace pipescout
