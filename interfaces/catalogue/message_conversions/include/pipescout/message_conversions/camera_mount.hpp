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

/// Where a camera is on a robot: always in the same place, or on an arm, of which /tf tells.
class CameraMount {
 public:
  /// Always in the same place.
  explicit CameraMount(const geometry::SE3& T_base_camera);
  /// On an arm, where the transform from `base_frame` to `camera_frame` on /tf says.
  CameraMount(std::string base_frame, std::string camera_frame);

  [[nodiscard]] bool moves() const noexcept { return !fixed_; }
  /// Takes the transforms of this camera from the message. One that is not later than the last one
  /// is left out; one from long before begins anew. Throws std::invalid_argument naming the field
  /// of one that is no pose.
  void add(const tf2_msgs::msg::TFMessage& message);
  /// Between two transforms interpolated, after the last one moved on as it moved before. Nothing
  /// before the first one, and more than 0.2 s from the one before.
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

  /// Of the first two; as `camera_mounting`.
  [[nodiscard]] geometry::SE3 T_base_camera() const;
  /// On an arm where `camera.frame` has a name. Throws as `camera_mounting`.
  [[nodiscard]] CameraMount read() const;

 private:
  Parameter<std::vector<double>> position_;
  Parameter<std::vector<double>> roll_pitch_yaw_;
  Parameter<std::string> camera_frame_;
  Parameter<std::string> base_frame_;
};

}  // namespace pipescout
