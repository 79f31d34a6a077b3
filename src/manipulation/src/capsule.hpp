// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace pipescout::manipulation::internal {

/// All points within `radius` of the straight line between two points, m. A sphere when these are
/// one.
struct Capsule {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
  double radius = 0;
};

/// m, between the surfaces; negative where they overlap.
[[nodiscard]] double distance(const Capsule& a, const Capsule& b) noexcept;

}  // namespace pipescout::manipulation::internal
