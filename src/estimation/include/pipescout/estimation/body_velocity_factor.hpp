// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Velocity of a point of the body in the axes of the body, such as that of a base's own odometry,
/// or of a Doppler log.
struct BodyVelocityMeasurement {
  using FactorType = class BodyVelocityFactor;
  double time = 0;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s, in the body
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();        ///< m, of the point in the body
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, as measured by the gyro; used
                                                           ///< if the point is not the origin
};

[[nodiscard]] InputFault check(const BodyVelocityMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const BodyVelocityMeasurement& m, Fingerprint& fingerprint);

/// W (R^T v + (w - b) x s - z), as VelocityFactor.
class BodyVelocityFactor : public WhitenedFactor<BodyVelocityMeasurement, 3> {
 public:
  static constexpr bool kUsesGlobals = false;
  static constexpr bool kNeedsMap = false;
  explicit BodyVelocityFactor(const BodyVelocityMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
