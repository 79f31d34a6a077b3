// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Height of a point of the body, such as that of a barometer.
struct HeightMeasurement {
  using FactorType = class HeightFactor;
  double time = 0;
  double height = 0;                                 ///< m, in the map
  double standard_deviation = 0;                     ///< m
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();  ///< m, of the point in the body
  /// Which of GlobalStates::own is added to the height, m; negative: none.
  int bias = -1;
};

[[nodiscard]] InputFault check(const HeightMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const HeightMeasurement& m, Fingerprint& fingerprint);

/// m, height of a pressure in Pa in the standard atmosphere (ISO 2533, below 11 km). The weather
/// moves it by up to 300 m, and by some metres an hour: the bias of the measurement is a state that
/// walks. NaN for a negative pressure.
[[nodiscard]] double pressure_height(double pressure) noexcept;

/// (e_z^T (p + R s) + c - z) / sigma, with s the point and c the bias.
class HeightFactor : public WhitenedFactor<HeightMeasurement, 1> {
 public:
  explicit HeightFactor(const HeightMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
