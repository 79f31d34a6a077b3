// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/estimation/factor.hpp"
#include "pipescout/estimation/imu_preintegration.hpp"

namespace pipescout::estimation {

/// Motions of an IMU from keyframes to the times of a measurement; of zero duration where these are
/// equal.
struct CarryingMotions {
  ImuMotion from{};  ///< to the measurement, or its `from_time`
  ImuMotion to{};    ///< to its `to_time`; from the next keyframe, or from the same one
};

/// The residual of a factor whose measurement lies after the keyframes, and its derivatives by the
/// states there and the globals: equation (44) chained with the factor's own.
void evaluate_carried(const AnyFactor& factor, const CarryingMotions& motions, const NavState& from,
                      const NavState& to, const GlobalStates& globals, const Gravity& gravity,
                      bool with_derivatives, FactorValue& value);

/// The squared norm of that residual.
[[nodiscard]] double chi_square(const AnyFactor& factor, const CarryingMotions& motions,
                                const NavState& from, const NavState& to,
                                const GlobalStates& globals, const Gravity& gravity);

}  // namespace pipescout::estimation
