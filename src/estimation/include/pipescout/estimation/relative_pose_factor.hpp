// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Motion of the body between two times.
struct RelativePoseMeasurement {
  using FactorType = class RelativePoseFactor;
  double from_time = 0;
  double to_time = 0;
  geometry::SE3 T_from_to{};
  /// [translation; rotation], both in the body frame at `to_time` (right)
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
};

[[nodiscard]] InputFault check(const RelativePoseMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const RelativePoseMeasurement& m, Fingerprint& fingerprint);

/// W [R_z^T (R_i^T (p_j - p_i) - t); log(R_z^T R_i^T R_j)]
class RelativePoseFactor
    : public MeasuredFactor<RelativePoseMeasurement, FactorKind::kRelativePose, 6> {
 public:
  static constexpr bool kUsesGlobals = false;
  explicit RelativePoseFactor(const RelativePoseMeasurement& measurement);
  Residual evaluate(const NavState& from, const NavState& to, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
