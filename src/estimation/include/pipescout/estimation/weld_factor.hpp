// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Passage of a weld at a known position. Created by `PipeCentreLine::weld`, or by hand.
struct WeldMeasurement {
  using FactorType = class WeldFactor;
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, of the weld in the map
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit, of the pipe there, in the map
  double along_deviation = 0;                            ///< m, along the pipe
  double across_deviation = 0;                           ///< m, across it
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();      ///< m, of the weld sensor in the body
};

[[nodiscard]] InputFault check(const WeldMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const WeldMeasurement& m, Fingerprint& fingerprint);

/// W (p + R l - z), with different standard deviations across the pipe and along it.
class WeldFactor : public MeasuredFactor<WeldMeasurement, FactorKind::kWeld, 3> {
 public:
  static constexpr bool kUsesGlobals = false;
  explicit WeldFactor(const WeldMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
