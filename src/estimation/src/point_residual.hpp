// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/state.hpp"

namespace pipescout::estimation {

/// W (p + R s - z): how far a point `sensor` of the body (m) is from `position` (m, in the map),
/// and the derivatives where they are asked for.
inline Eigen::Vector3d point_residual(const NavState& x, const Eigen::Vector3d& sensor,
                                      const Eigen::Vector3d& position,
                                      const Eigen::Matrix3d& whitening, Jacobians<3>* derivatives) {
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kPosition) = whitening;
    derivatives->from.middleCols<3>(kRotation) =
        -whitening * x.R_map_body.matrix() * geometry::skew(sensor);
  }
  return whitening * (x.position + x.R_map_body * sensor - position);
}

}  // namespace pipescout::estimation
