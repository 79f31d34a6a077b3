// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Distance that a point of the body, the wheel, has travelled along the direction of travel,
/// forwards positive, on an arc.
struct OdometerMeasurement {
  using FactorType = class OdometerFactor;
  double from_time = 0;
  double to_time = 0;
  double distance = 0;            ///< m, before the scale
  double standard_deviation = 0;  ///< m
  /// m, standard deviation of the lateral and vertical slip of the point
  double across_deviation = 0;
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();  ///< m, of the point in the body
};

[[nodiscard]] InputFault check(const OdometerMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const OdometerMeasurement& m, Fingerprint& fingerprint);

/// W (K M^T (R_i + R_j)^T (q_j - q_i) / 2 - [d sin(a) / a; 0; 0]), with q = p + R s the position of
/// the point in the map, K = diag(1/k, 1, 1), k the scale, d the distance and a the angle of R_i^T
/// R_j: exact for an arc of a circle whose axis is across the travel. The scale multiplies the
/// states and not d: if it multiplied the noise of d, the minimum of the cost would be biased
/// towards small scales. Not finite for a scale of 0.
class OdometerFactor : public MeasuredFactor<OdometerMeasurement, FactorKind::kOdometer, 3> {
 public:
  explicit OdometerFactor(const OdometerMeasurement& measurement);
  Residual evaluate(const NavState& from, const NavState& to, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
