// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <pipescout/geometry/camera.hpp>
#include <pipescout/geometry/se3.hpp>
#include <vector>

#include "shadow.hpp"

namespace pipescout::rack_vision {

/// A camera at a pose, for clipping straight lines of the rack to its image. Points are relative to
/// the eye, in the axes of the rack, as in shadow.hpp.
class ImageWindow {
 public:
  /// Keeps a reference to the camera.
  ImageWindow(const geometry::Camera& camera, const geometry::SE3& T_camera_rack);

  [[nodiscard]] const Eigen::Vector3d& eye() const noexcept { return eye_; }
  /// Bounds of all that the image can show.
  [[nodiscard]] const ViewPlanes& planes() const noexcept { return planes_; }
  /// Ideal pixel of a point in front of the camera.
  [[nodiscard]] Eigen::Vector2d pixel(const Eigen::Vector3d& point) const noexcept;

  /// Clips the segment to `planes` and to what is in front of the camera; false: nothing is left.
  [[nodiscard]] bool clip(Eigen::Vector3d& start, Eigen::Vector3d& end) const noexcept;

  /// Appends the parts of a clipped segment that a distorted image does not show. Without
  /// distortion there are none.
  void append_outside(const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                      std::vector<Interval>& outside) const;

 private:
  [[nodiscard]] bool shows(const Eigen::Vector3d& point) const noexcept;

  const geometry::Camera& camera_;
  Eigen::Matrix3d projection_;  ///< K R_camera_rack
  Eigen::Vector3d eye_;
  ViewPlanes planes_;
};

}  // namespace pipescout::rack_vision
