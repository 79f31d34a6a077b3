// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/message_conversions/odometry_history.hpp"
#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

/// Pose of a camera on a robot: constant, or on an arm, where /tf gives it.
class CameraMount {
 public:
  /// Constant pose.
  explicit CameraMount(const geometry::SE3& T_base_camera);
  /// On an arm: the transform from `base_frame` to `camera_frame` on /tf.
  CameraMount(std::string base_frame, std::string camera_frame);

  [[nodiscard]] bool moves() const noexcept { return !fixed_; }
  /// Stores the transforms of this camera from the message. A transform that is not later than the
  /// last one is ignored; one from long before restarts the history. Throws std::invalid_argument
  /// naming the field of an invalid pose.
  void add(const tf2_msgs::msg::TFMessage& message);
  /// Interpolated between two transforms, extrapolated after the last one with its last velocity.
  /// Nothing before the first transform, or more than 0.2 s after the preceding one.
  [[nodiscard]] std::optional<geometry::SE3> T_base_camera(Time time) const;

 private:
  std::optional<geometry::SE3> fixed_;
  std::string base_frame_;
  std::string camera_frame_;
  OdometryHistory history_;
  std::optional<OdometryHistory::Entry> last_;
};

/// The parameters `camera.position`, `camera.roll_pitch_yaw`, `camera.frame` and `base_frame`.
class CameraMountParameters {
 public:
  /// Declares them.
  explicit CameraMountParameters(Parameters& parameters);

  /// From the first two, as `camera_mounting`.
  [[nodiscard]] geometry::SE3 T_base_camera() const;
  /// On an arm if `camera.frame` is not empty. Throws as `camera_mounting`.
  [[nodiscard]] CameraMount read() const;

 private:
  Parameter<std::vector<double>> position_;
  Parameter<std::vector<double>> roll_pitch_yaw_;
  Parameter<std::string> camera_frame_;
  Parameter<std::string> base_frame_;
};

}  // namespace pipescout
