// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/camera_mount.hpp"

#include <chrono>
#include <utility>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/mounting_parameters.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout {
namespace {

/// How far, s, two transforms may lie apart, and a picture from the last one.
constexpr Duration kReach = std::chrono::milliseconds(200);
/// Over which the motion at the last transform is taken.
constexpr Duration kStep = std::chrono::milliseconds(10);

}  // namespace

CameraMount::CameraMount(const geometry::SE3& T_base_camera) : fixed_(T_base_camera) {}

CameraMount::CameraMount(const Transforms& transforms, std::string base_frame,
                         std::string camera_frame)
    : transforms_(&transforms),
      base_frame_(std::move(base_frame)),
      camera_frame_(std::move(camera_frame)) {}

std::optional<geometry::SE3> CameraMount::T_base_camera(Time time, std::string* why) const {
  if (fixed_) {
    return fixed_;
  }
  const TransformResult found = transforms_->lookup(base_frame_, camera_frame_, time);
  if (found && found.gap() <= kReach) {
    return from_message(found->transform);
  }
  if (!found && found.failure().error == TransformError::kFuture) {
    if (const auto moved = moved_on(time)) {
      return moved;
    }
  }
  if (why != nullptr) {
    *why = found ? "the transforms from '" + camera_frame_ + "' to '" + base_frame_ + "' lie " +
                       validation::number_text(to_seconds(found.gap())) + " s apart"
                 : found.failure().text;
  }
  return std::nullopt;
}

std::optional<geometry::SE3> CameraMount::moved_on(Time time) const {
  const TransformResult latest = transforms_->lookup(base_frame_, camera_frame_);
  if (!latest) {
    return std::nullopt;
  }
  const Time last = from_message(latest->header.stamp);
  if (time - last > kReach) {
    return std::nullopt;
  }
  const geometry::SE3 pose = from_message(latest->transform);
  const TransformResult before = transforms_->lookup(base_frame_, camera_frame_, last - kStep);
  if (!before || before.gap() > kReach) {
    return pose;
  }
  const geometry::Vector6d twist =
      (from_message(before->transform).inverse() * pose).log() / to_seconds(kStep);
  return pose * geometry::SE3::exp(to_seconds(time - last) * twist);
}

CameraMountParameters::CameraMountParameters(Parameters& parameters)
    : CameraMountParameters(
          parameters, parameters.declare<std::string>(
                          "base_frame", "base_link",
                          {.description = "base frame of the robot, parent of camera.frame"})) {}

CameraMountParameters::CameraMountParameters(Parameters& parameters,
                                             Parameter<std::string> base_frame)
    : base_frame_(std::move(base_frame)) {
  position_ = parameters.declare<std::vector<double>>(
      "camera.position", {},
      {.description = "m, x y z of the camera in the base frame of odometry; empty: 0 0 0"});
  roll_pitch_yaw_ = parameters.declare<std::vector<double>>(
      "camera.roll_pitch_yaw", {},
      {.description = "rad, of the optical frame in the base frame; empty: looks straight down, "
                      "the upper border of the image forward"});
  camera_frame_ = parameters.declare<std::string>(
      "camera.frame", "",
      {.description = "frame of the camera, whose pose against base_frame tf and tf_static tell; "
                      "empty: camera.position and camera.roll_pitch_yaw do"});
  history_ = parameters.declare<double>(
      "tf.history", 10.0,
      {.description =
           "s for which transforms are kept, where another component of the process does "
           "not ask for more",
       .floating_point_range = FloatingPointRange{.from = 1, .to = 600}});
}

geometry::SE3 CameraMountParameters::T_base_camera() const {
  return camera_mounting(position_, roll_pitch_yaw_);
}

CameraMount CameraMountParameters::read(Node& node) const {
  const std::string camera_frame = camera_frame_.get();
  if (camera_frame.empty()) {
    return CameraMount(T_base_camera());
  }
  node.transforms().require_history(from_seconds(history_.get()));
  return {node.transforms(), base_frame_.get(), camera_frame};
}

}  // namespace pipescout
