// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"

namespace pipescout::rack_vision {

/// What is believed of the camera's intrinsics from image to image, and the camera that is used.
class IntrinsicsMemory {
 public:
  /// `focal_sigma`, `centre_sigma`: how well the calibration is known, px.
  IntrinsicsMemory(const geometry::Camera& calibrated, double focal_sigma, double centre_sigma);

  void reset();
  /// After dt s, in which the lens may have warmed up.
  void predict(double dt);
  /// Takes over what an image said, which began with this belief. Errors of successive images are
  /// alike: each counts for one in so many. What leaves the calibration by more than is credible is
  /// not believed.
  void learn(const IntrinsicsBelief& after);

  [[nodiscard]] const IntrinsicsBelief& belief() const noexcept { return belief_; }
  /// The camera of the belief, when it has left the one in use far enough to be worth it, and is
  /// one; it is then the one in use.
  [[nodiscard]] std::optional<geometry::Camera> improved();
  /// Of the camera in use: focal length and centre.
  [[nodiscard]] const Eigen::Vector3d& in_use() const noexcept { return in_use_; }

 private:
  geometry::CameraParameters calibrated_;
  Eigen::Vector3d sigma_;
  IntrinsicsBelief belief_;
  Eigen::Vector3d in_use_;
};

}  // namespace pipescout::rack_vision
