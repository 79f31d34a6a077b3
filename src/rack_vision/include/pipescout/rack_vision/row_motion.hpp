// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/geometry/se3.hpp"

namespace pipescout::rack_vision {

/// Motion of a camera with a rolling shutter while it takes one image (Meingast, Geyer and Sastry,
/// "Geometric models of rolling-shutter cameras", 2005): rows are exposed one after the other, from
/// the top. The pose of the image is that of the middle row; the velocity is constant over the
/// rows.
struct RowMotion {
  double row_time = 0;    ///< s from one row to the next below, >= 0; 0: global shutter
  double middle_row = 0;  ///< v of the middle of the (distorted) image, pixels
  /// Estimated velocity of the camera: [m/s along the rack's axes; rad/s about them].
  geometry::Vector6d velocity = geometry::Vector6d::Zero();
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();  ///< of `velocity`

  [[nodiscard]] bool is_rolling() const noexcept { return row_time > 0; }

  /// s from the exposure of the middle row to that of another row of the (distorted) image.
  [[nodiscard]] double instant(double row) const noexcept { return row_time * (row - middle_row); }

  /// T_rack_camera when a row is exposed, for that of the image.
  [[nodiscard]] geometry::SE3 pose_at(const geometry::SE3& T_rack_camera, double row) const;

  /// Variance that the velocity adds to that pose, in the form of pose_solver.hpp.
  [[nodiscard]] geometry::Matrix6d covariance_at(double row) const {
    return instant(row) * instant(row) * covariance;
  }
};

}  // namespace pipescout::rack_vision
