// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/runtime/node.hpp"

namespace pipescout {

/// Where a camera is on a robot: always in the same place, or on an arm, of which the transforms
/// tell.
class CameraMount {
 public:
  /// Constant pose.
  explicit CameraMount(const geometry::SE3& T_base_camera);
  /// On an arm, where the chain of transforms from `camera_frame` to `base_frame` says.
  /// `transforms` must outlive it.
  CameraMount(const Transforms& transforms, std::string base_frame, std::string camera_frame);

  [[nodiscard]] bool moves() const noexcept { return !fixed_; }
  /// Between two transforms interpolated, after the last one moved on as it moved before. Nothing
  /// before the first one, and more than 0.2 s from the one before; then `why`, when given, names
  /// the frame or the transform that is missing.
  [[nodiscard]] std::optional<geometry::SE3> T_base_camera(Time time,
                                                           std::string* why = nullptr) const;

 private:
  /// After the last transform.
  [[nodiscard]] std::optional<geometry::SE3> moved_on(Time time) const;

  std::optional<geometry::SE3> fixed_;
  const Transforms* transforms_ = nullptr;  // not null without `fixed_`
  std::string base_frame_;
  std::string camera_frame_;
};

/// The parameters `camera.position`, `camera.roll_pitch_yaw`, `camera.frame`, `base_frame` and
/// `tf.history`.
class CameraMountParameters {
 public:
  /// Declares them.
  explicit CameraMountParameters(Parameters& parameters);
  /// The same with a `base_frame` that is declared already.
  CameraMountParameters(Parameters& parameters, Parameter<std::string> base_frame);

  /// From the first two, as `camera_mounting`.
  [[nodiscard]] geometry::SE3 T_base_camera() const;
  /// On an arm where `camera.frame` has a name; only then `node` listens to transforms. Throws as
  /// `camera_mounting` and as `Node::transforms`.
  [[nodiscard]] CameraMount read(Node& node) const;

 private:
  Parameter<std::vector<double>> position_;
  Parameter<std::vector<double>> roll_pitch_yaw_;
  Parameter<std::string> camera_frame_;
  Parameter<std::string> base_frame_;
  Parameter<double> history_;
};

}  // namespace pipescout
