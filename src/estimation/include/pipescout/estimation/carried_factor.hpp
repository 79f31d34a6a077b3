// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/estimation/factors.hpp"
#include "pipescout/estimation/imu_preintegration.hpp"

namespace pipescout::estimation {

/// Motions of an IMU from keyframes to the times of a measurement; of zero duration where these are
/// equal.
struct CarryingMotions {
  ImuMotion from{};  ///< to the measurement, or its `from_time`
  ImuMotion to{};    ///< to its `to_time`; from the next keyframe, or from the same one
};

/// The residual of a factor of factors.hpp whose measurement lies after the keyframes, and its
/// derivatives by the states there and the globals: equation (44) chained with the factor's own.
/// Derivatives as in factors.hpp. A factor of one time leaves `to` alone. `gravity` m/s^2.
/// Compiled for the alternatives of AnyFactor.
template <class Factor>
typename Factor::Residual evaluate_carried(const Factor& factor, const CarryingMotions& motions,
                                           const NavState& from, const NavState& to,
                                           const GlobalStates& globals, double gravity,
                                           typename Factor::Derivatives* derivatives = nullptr);

}  // namespace pipescout::estimation
