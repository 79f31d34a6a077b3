// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"

namespace pipescout::tracking {

/// Motion of the image: a velocity field that is linear about a point.
struct ImageMotion {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();        ///< px
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< px/s, of the scene at that point
  /// 1/s: derivative of the velocity by position
  Eigen::Matrix2d gradient = Eigen::Matrix2d::Zero();

  /// Velocity of the scene at a point, px/s.
  [[nodiscard]] Eigen::Vector2d of(const Eigen::Vector2d& point) const {
    return velocity + gradient * (point - at);
  }
  /// Finite and within the bounds below.
  [[nodiscard]] bool usable() const {
    constexpr double kFarthest = 1e6;         // px
    constexpr double kFastest = 1e6;          // px/s
    constexpr double kFastestGradient = 1e3;  // 1/s
    return at.cwiseAbs().maxCoeff() < kFarthest && velocity.cwiseAbs().maxCoeff() < kFastest &&
           gradient.cwiseAbs().maxCoeff() < kFastestGradient && at.allFinite() &&
           velocity.allFinite() && gradient.allFinite();
  }
};

/// The velocity of a camera that is fixed to a body: [linear m/s; angular rad/s], against the
/// world, in the camera's frame, from that of the body in the body's.
[[nodiscard]] geometry::Vector6d camera_velocity(const geometry::SE3& T_body_camera,
                                                 const geometry::Vector6d& body_velocity);

/// Motion in the image of a static scene at `depth` m (along the camera's z, on a plane parallel to
/// the image) for a camera with `camera_velocity`: the interaction matrix of a point (Chaumette and
/// Hutchinson, IEEE Robotics and Automation Magazine 13, 2006, equation 11), and its derivative by
/// position. Lens distortion is not considered: rectify first. Nothing for a depth that is not
/// positive, or numbers that are not finite.
[[nodiscard]] std::optional<ImageMotion> image_motion(const geometry::Camera& camera,
                                                      const Eigen::Vector2d& at, double depth,
                                                      const geometry::Vector6d& camera_velocity);

}  // namespace pipescout::tracking
