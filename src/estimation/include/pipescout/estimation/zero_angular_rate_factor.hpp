// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// The body does not rotate.
struct ZeroAngularRateMeasurement {
  using FactorType = class ZeroAngularRateFactor;
  double time = 0;
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, as measured by the gyro
  double standard_deviation = 0;                           ///< rad/s, per axis
};

[[nodiscard]] InputFault check(const ZeroAngularRateMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const ZeroAngularRateMeasurement& m, Fingerprint& fingerprint);

/// (w - b) / sigma, b the bias of the gyro
class ZeroAngularRateFactor
    : public MeasuredFactor<ZeroAngularRateMeasurement, FactorKind::kZeroAngularRate, 3> {
 public:
  static constexpr bool kNeedsMap = false;
  static constexpr bool kUsesGlobals = false;
  explicit ZeroAngularRateFactor(const ZeroAngularRateMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
