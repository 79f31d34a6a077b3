// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace pipescout::estimation {

/// How the map lies on the Earth: x east, y north, z up at its origin, and tangent to the Earth
/// there, as geometry::LocalFrame has it. The default is a flat Earth at rest: the direction of
/// gravity is off by 8 mrad at 50 km from the origin then, and the gyro sees the Earth turn.
struct Earth {
  /// m, radii of curvature along x (prime vertical) and y (meridian); 0: flat, else in [6e6, 7e6].
  Eigen::Vector2d radii = Eigen::Vector2d::Zero();
  /// rad/s, angular rate of the map in inertial space, along its axes; each in [-1e-4, 1e-4].
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();

  /// Of a map whose origin is at a latitude, degrees: WGS 84 (NIMA TR8350.2, 2000, table 3.1; radii
  /// by Groves, "Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems",
  /// 2013, equations 2.105 and 2.106). Throws std::invalid_argument unless it is in [-90, 90].
  [[nodiscard]] static Earth at_latitude(double latitude);
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// What makes a body move that no other force acts on, in the map.
class Gravity {
 public:
  // Implicit: a number is gravity on a flat Earth.
  Gravity(double magnitude) : magnitude_(magnitude) {}
  Gravity(double magnitude, const Earth& earth)
      : magnitude_(magnitude), curved_(earth.radii.x() > 0), rate_(earth.rate) {
    if (curved_) {
      curvature_ = earth.radii.cwiseInverse();
    }
  }

  /// m/s^2: gravity, along the vertical of the place, and the Coriolis acceleration. Their
  /// derivatives by position and velocity, 2e-6 /s^2 and 1.5e-4 /s, are left out of factors.
  [[nodiscard]] Eigen::Vector3d acceleration(const Eigen::Vector3d& position,
                                             const Eigen::Vector3d& velocity) const {
    if (!curved_) {
      return {0, 0, -magnitude_};
    }
    const Eigen::Vector3d down =
        -Eigen::Vector3d(position.x() * curvature_.x(), position.y() * curvature_.y(), 1)
             .normalized();
    return magnitude_ * down - 2 * rate_.cross(velocity);
  }

 private:
  double magnitude_;
  bool curved_ = false;
  Eigen::Vector2d curvature_ = Eigen::Vector2d::Zero();  // 1/m
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero();
};

}  // namespace pipescout::estimation
