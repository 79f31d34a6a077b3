// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/first_pose.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

/// Tracker and initialisation take the pipes to run along y. Racks with another main direction are
/// turned for them.
namespace pipescout::rack_vision {

class FlowFrame {
 public:
  /// Turned so that the main direction of `model` is y. Throws InvalidRack for supports in a rack
  /// whose main direction is not along an axis: turned, they would not be along the axes.
  explicit FlowFrame(const RackModel& model);

  /// In this frame. Where it is not the rack's own, no pipe is movable: offsets are along rack x.
  [[nodiscard]] const RackModel& model() const noexcept { return model_; }

  [[nodiscard]] geometry::SE3 from_rack(const geometry::SE3& T_rack_camera) const;
  [[nodiscard]] geometry::SE3 to_rack(const geometry::SE3& T_flow_camera) const;
  /// Of [position; rotation] along and about the axes.
  [[nodiscard]] geometry::Matrix6d from_rack(const geometry::Matrix6d& covariance) const;
  [[nodiscard]] geometry::Matrix6d to_rack(const geometry::Matrix6d& covariance) const;
  /// Of a position in an oblique rack only what is known of x and y together remains.
  [[nodiscard]] FirstPoseHint from_rack(const FirstPoseHint& hint) const;

 private:
  std::optional<geometry::SO3> R_flow_rack_;  ///< nothing: they are one frame
  RackModel model_;
};

}  // namespace pipescout::rack_vision
