// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Direction of the Earth's magnetic field in the body; its strength and its dip are not used.
struct MagneticFieldMeasurement {
  using FactorType = class MagneticFieldFactor;
  double time = 0;
  Eigen::Vector3d field = Eigen::Vector3d::Zero();  ///< of any unit, in the body
  double declination = 0;         ///< rad, of magnetic north from the map's y axis, east positive
  double standard_deviation = 0;  ///< rad, of the heading
  /// Which of GlobalStates::own is added to the declination, rad; negative: none.
  int bias = -1;
};

[[nodiscard]] InputFault check(const MagneticFieldMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const MagneticFieldMeasurement& m, Fingerprint& fingerprint);

/// (atan2(h_y, h_x) - (pi / 2 - D - c)) in (-pi, pi] / sigma, with h = R m the field in the map, D
/// the declination and c the bias. NaN, with its derivatives, where less than a hundredth of the
/// field is horizontal.
class MagneticFieldFactor : public WhitenedFactor<MagneticFieldMeasurement, 1> {
 public:
  explicit MagneticFieldFactor(const MagneticFieldMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
