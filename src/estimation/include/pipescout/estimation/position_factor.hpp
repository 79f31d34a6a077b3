// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Position of a point of the body, such as another antenna of a GPS receiver.
struct PositionMeasurement {
  using FactorType = class PositionFactor;
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, in the map
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();  ///< m, of the point in the body
};

[[nodiscard]] InputFault check(const PositionMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const PositionMeasurement& m, Fingerprint& fingerprint);

/// W (p + R s - z), with s the point.
class PositionFactor : public WhitenedFactor<PositionMeasurement, 3> {
 public:
  static constexpr bool kUsesGlobals = false;
  explicit PositionFactor(const PositionMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
