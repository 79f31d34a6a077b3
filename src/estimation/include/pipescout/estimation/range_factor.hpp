// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Distance of a point of the body from a beacon at a known position.
struct RangeMeasurement {
  using FactorType = class RangeFactor;
  double time = 0;
  double range = 0;                                  ///< m
  double standard_deviation = 0;                     ///< m
  Eigen::Vector3d beacon = Eigen::Vector3d::Zero();  ///< m, in the map
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();  ///< m, of the point in the body
  /// Which of GlobalStates::own is added to the range, m; negative: none.
  int bias = -1;
};

[[nodiscard]] InputFault check(const RangeMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const RangeMeasurement& m, Fingerprint& fingerprint);

/// (|p + R s - q| + c - z) / sigma, with s the point, q the beacon and c the bias. NaN, with its
/// derivatives, within a millimetre of the beacon.
class RangeFactor : public WhitenedFactor<RangeMeasurement, 1> {
 public:
  explicit RangeFactor(const RangeMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
