// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/so3.hpp"
#include "pipescout/manipulation/arm_controller.hpp"

namespace pipescout::manipulation::internal {

/// What one image shows of a straight pipe, in the camera frame.
struct SectionView {
  /// Unit normal of the plane through the camera and the pipe's axis, on the side of y.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();
  /// rad, about the normal, from the optical axis to the middle of the section; 0 unless an end of
  /// it is in the image.
  double turn = 0;
  /// Of the image's height, from its middle row to the farther end of the section.
  double offset = 0;
};
/// Nothing when the section is too short to have a direction, or outside what the camera's
/// intrinsics hold for.
[[nodiscard]] std::optional<SectionView> view_of(const PipeSection& section,
                                                 const geometry::Camera& camera) noexcept;

/// The plane as it is believed to be, in a frame at rest.
class PipePlane {
 public:
  /// From an image: `share`, (0, 1], of what is new goes into it; the first one goes wholly.
  void observe(const Eigen::Vector3d& normal, double range, double share);
  /// The camera, which looks at the pipe along `forward`, has moved by `moved`, m.
  void move(const Eigen::Vector3d& moved, const Eigen::Vector3d& forward);
  void forget() noexcept { known_ = false; }

  [[nodiscard]] bool known() const noexcept { return known_; }
  [[nodiscard]] const Eigen::Vector3d& normal() const noexcept { return normal_; }  ///< unit
  [[nodiscard]] double range() const noexcept { return range_; }                    ///< m

 private:
  bool known_ = false;
  Eigen::Vector3d normal_ = Eigen::Vector3d::UnitY();
  double range_ = 0;
};

/// The rotation of a camera whose y axis is `normal` and whose optical axis is as near to `forward`
/// as may be. Unit vectors of one frame. `forward` may not be along the normal.
[[nodiscard]] geometry::SO3 looking_along(const Eigen::Vector3d& normal,
                                          const Eigen::Vector3d& forward);

}  // namespace pipescout::manipulation::internal
