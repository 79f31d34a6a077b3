// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// The body is in a pipe whose centre line passes through `position`; the position along it is not
/// constrained.
struct CentreLineMeasurement {
  using FactorType = class CentreLineFactor;
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, in the map
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit, of the line there, in the map
  double standard_deviation = 0;  ///< m, of the body from the line, per axis across it
};

[[nodiscard]] InputFault check(const CentreLineMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const CentreLineMeasurement& m, Fingerprint& fingerprint);

/// W A (p - z); the rows of A are of length 1, across the line and across each other.
class CentreLineFactor : public MeasuredFactor<CentreLineMeasurement, FactorKind::kCentreLine, 2> {
 public:
  static constexpr bool kUsesGlobals = false;
  explicit CentreLineFactor(const CentreLineMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;

 private:
  Eigen::Matrix<double, 2, 3, Eigen::DontAlign> across_;
};

}  // namespace pipescout::estimation
