// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Antenna position. Lever arm and time offset are in `GlobalStates`.
struct GpsMeasurement {
  using FactorType = class GpsFactor;
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, in the map
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// rad/s, in the body, at that time; 0 if unknown. It moves the antenna only during the time
  /// offset, so that the gyro bias is negligible.
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();
};

[[nodiscard]] InputFault check(const GpsMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const GpsMeasurement& m, Fingerprint& fingerprint);

/// W (p + t v + R (l + t w x l) - z), with l the lever arm, t the time offset and w the angular
/// rate.
class GpsFactor : public MeasuredFactor<GpsMeasurement, FactorKind::kGps, 3> {
 public:
  explicit GpsFactor(const GpsMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
