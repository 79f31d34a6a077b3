// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Velocity of a point of the body in the map, such as that which a GPS receiver measures. A speed
/// with a course is one too: its covariance is then large across the course, or along it.
struct VelocityMeasurement {
  using FactorType = class VelocityFactor;
  double time = 0;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s, in the map
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();        ///< m, of the point in the body
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, as measured by the gyro; used
                                                           ///< if the point is not the origin
};

[[nodiscard]] InputFault check(const VelocityMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const VelocityMeasurement& m, Fingerprint& fingerprint);

/// W (v + R ((w - b) x s) - z), with s the point, w the angular rate and b the bias of the gyro,
/// whose scale errors are negligible here.
class VelocityFactor : public WhitenedFactor<VelocityMeasurement, 3> {
 public:
  static constexpr bool kUsesGlobals = false;
  explicit VelocityFactor(const VelocityMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
