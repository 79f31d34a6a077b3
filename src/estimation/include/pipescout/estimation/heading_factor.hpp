// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Angle of the body's x axis about the map's z axis, from the map's x axis.
struct HeadingMeasurement {
  using FactorType = class HeadingFactor;
  double time = 0;
  double heading = 0;
  double standard_deviation = 0;
};

[[nodiscard]] InputFault check(const HeadingMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const HeadingMeasurement& m, Fingerprint& fingerprint);

/// (atan2(e_y, e_x) - z) / sigma in (-pi, pi] / sigma, e = R [1 0 0]^T. NaN, with its derivatives,
/// where the body's x axis is within 1e-3 rad of the vertical.
class HeadingFactor : public MeasuredFactor<HeadingMeasurement, FactorKind::kHeading, 1> {
 public:
  static constexpr bool kUsesGlobals = false;
  explicit HeadingFactor(const HeadingMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
