// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// A point of the body, its wheels' or tracks', moves along the direction of travel
/// (`GlobalStates::mount_yaw`, `mount_pitch`) only.
struct NonHolonomicMeasurement {
  using FactorType = class NonHolonomicFactor;
  double time = 0;
  double lateral_deviation = 0;                            ///< m/s
  double vertical_deviation = 0;                           ///< m/s
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();        ///< m, of the point in the body
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, as measured by the gyro; used
                                                           ///< if the point is not the origin
};

[[nodiscard]] InputFault check(const NonHolonomicMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const NonHolonomicMeasurement& m, Fingerprint& fingerprint);

/// W (M^T (R^T v + (w - b) x s)) without its first row; M = Rz(mount yaw) Ry(mount pitch), s the
/// point, w the angular rate and b the bias of the gyro.
class NonHolonomicFactor
    : public MeasuredFactor<NonHolonomicMeasurement, FactorKind::kNonHolonomic, 2> {
 public:
  static constexpr bool kNeedsMap = false;
  explicit NonHolonomicFactor(const NonHolonomicMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
