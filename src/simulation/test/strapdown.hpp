// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/simulation/body_motion.hpp"
#include "pipescout/simulation/uav.hpp"

namespace pipescout::simulation::test {

/// What an inertial navigator makes of perfect readings, from a true beginning: the readings at
/// both ends of a step averaged, the force turned by the attitude half way.
class Strapdown {
 public:
  explicit Strapdown(const BodyMotion& begin)
      : attitude_(begin.T_map_body.rotation()),
        position_(begin.T_map_body.translation()),
        velocity_(begin.velocity),
        last_(begin) {}

  void advance(const BodyMotion& now, double duration) {
    const Eigen::Vector3d rate = (last_.angular_rate + now.angular_rate) / 2;
    const Eigen::Vector3d force = (last_.specific_force() + now.specific_force()) / 2;
    const Eigen::Vector3d acceleration =
        attitude_ * geometry::SO3::exp(duration / 2 * rate) * force -
        kGravity * Eigen::Vector3d::UnitZ();
    position_ += duration * (velocity_ + duration / 2 * acceleration);
    velocity_ += duration * acceleration;
    attitude_ = attitude_ * geometry::SO3::exp(duration * rate);
    last_ = now;
  }

  /// Against the motion that was advanced to last.
  [[nodiscard]] double position_error() const {  // m
    return (position_ - last_.T_map_body.translation()).norm();
  }
  [[nodiscard]] double velocity_error() const {  // m/s
    return (velocity_ - last_.velocity).norm();
  }
  [[nodiscard]] double attitude_error() const {  // rad
    return (attitude_.inverse() * last_.T_map_body.rotation()).log().norm();
  }

 private:
  geometry::SO3 attitude_;
  Eigen::Vector3d position_;
  Eigen::Vector3d velocity_;
  BodyMotion last_;
};

}  // namespace pipescout::simulation::test
