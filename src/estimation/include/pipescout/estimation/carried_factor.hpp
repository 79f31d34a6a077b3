// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/estimation/imu_preintegration.hpp"

namespace pipescout::estimation {

/// Motions of an IMU from keyframes to the times of a measurement; of no duration where these are
/// the same.
struct CarryingMotions {
  ImuMotion from{};  ///< to the measurement, or its `from_time`
  ImuMotion to{};    ///< to its `to_time`; from the next keyframe, or from the same one
};

/// The residual of a factor of factors.hpp whose measurement lies after the keyframes, and its
/// derivatives by the states there and the globals: equation (44) chained with the factor's own.
/// Derivatives as in factors.hpp. A factor of one time leaves `to` alone. `gravity` m/s^2.
template <class Factor>
typename Factor::Residual evaluate_carried(const Factor& factor, const CarryingMotions& motions,
                                           const NavState& from, const NavState& to,
                                           const GlobalStates& globals, double gravity,
                                           typename Factor::Derivatives* derivatives = nullptr) {
  struct By {
    StateMatrix state;
    ImuMotion::ScaleJacobian scale;
  };
  By by_from;
  By by_to;
  const auto carry = [&](const ImuMotion& motion, const NavState& state, By& by) {
    const bool derive = derivatives != nullptr;
    return motion.duration() > 0
               ? motion.propagate(state, globals.imu_scale, gravity, derive ? &by.state : nullptr,
                                  derive ? &by.scale : nullptr)
               : state;
  };
  const auto chain = [&](const ImuMotion& motion, const By& by, auto& by_carried) {
    if (motion.duration() <= 0) {
      return;
    }
    if (motion.scaled()) {
      derivatives->globals.template middleCols<kImuScaleSize>(kImuScale).noalias() +=
          by_carried.template leftCols<9>() * by.scale;
    }
    by_carried = (by_carried * by.state).eval();
  };
  typename Factor::Residual residual;
  if constexpr (Factor::kRelative) {
    residual = factor.evaluate(carry(motions.from, from, by_from), carry(motions.to, to, by_to),
                               globals, derivatives);
    if (derivatives != nullptr) {
      chain(motions.to, by_to, derivatives->to);
    }
  } else {
    residual = factor.evaluate(carry(motions.from, from, by_from), globals, derivatives);
  }
  if (derivatives != nullptr) {
    chain(motions.from, by_from, derivatives->from);
  }
  return residual;
}

}  // namespace pipescout::estimation
