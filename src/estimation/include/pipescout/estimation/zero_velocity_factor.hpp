// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Standstill of the body.
struct ZeroVelocityMeasurement {
  using FactorType = class ZeroVelocityFactor;
  double time = 0;
  double standard_deviation = 0;  ///< m/s, per axis
};

[[nodiscard]] InputFault check(const ZeroVelocityMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const ZeroVelocityMeasurement& m, Fingerprint& fingerprint);

/// v / sigma
class ZeroVelocityFactor
    : public MeasuredFactor<ZeroVelocityMeasurement, FactorKind::kZeroVelocity, 3> {
 public:
  static constexpr bool kNeedsMap = false;
  static constexpr bool kUsesGlobals = false;
  explicit ZeroVelocityFactor(const ZeroVelocityMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
