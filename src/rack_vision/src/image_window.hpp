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
  /// A part of a segment, and how far (pixels) it is seen inside the border of the image.
  struct Place {
    double at = 0;
    double inside = 0;
    [[nodiscard]] bool is_shown() const noexcept { return inside >= 0; }
  };
  static constexpr double kFarOutside = -1e9;  ///< where there is no pixel

  [[nodiscard]] double inside_border(const Eigen::Vector3d& point) const noexcept;
  /// The last place that is shown, to 0.002 pixels, between one that is and one that is not.
  [[nodiscard]] double border_between(const Eigen::Vector3d& start, const Eigen::Vector3d& along,
                                      Place shown, Place not_shown) const noexcept;

  const geometry::Camera& camera_;
  Eigen::Matrix3d rotation_;    ///< R_camera_rack
  Eigen::Matrix3d projection_;  ///< K R_camera_rack
  Eigen::Vector3d eye_;
  ViewPlanes planes_;
  ViewPlanes shown_planes_;  ///< what is inside all of them is shown, distortion or not
};

}  // namespace pipescout::rack_vision
