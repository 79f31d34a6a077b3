// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/pose_factor.hpp"

namespace pipescout::estimation {

InputFault check(const PoseMeasurement& m) noexcept {
  const InputFault fault = check(static_cast<const VisualPoseMeasurement&>(m));
  return fault == InputFault::kNone && m.clock >= kOwnSize ? InputFault::kNotFinite : fault;
}

PoseFactor::PoseFactor(const PoseMeasurement& measurement)
    : pose_(measurement), clock_(measurement.clock) {}

InputFault PoseFactor::fault() const noexcept {
  return clock_ < kOwnSize ? pose_.fault() : InputFault::kNotFinite;
}

VisualPoseFactor::Residual PoseFactor::evaluate(const NavState& x, const GlobalStates& globals,
                                                Jacobians<kRows>* derivatives) const {
  GlobalStates seen;
  seen.own = globals.own;
  seen.visual_pose_time_offset = clock_ >= 0 ? globals.own[clock_] : 0;
  const VisualPoseFactor::Residual residual = pose_.evaluate(x, seen, derivatives);
  if (derivatives != nullptr) {
    auto& by = derivatives->globals;
    by.middleCols<3>(kRackPosition).setZero();
    by.middleCols<3>(kRackRotation).setZero();
    if (clock_ >= 0) {
      by.col(kOwnStates + clock_) = by.col(kVisualPoseTimeOffset);
    }
    by.col(kVisualPoseTimeOffset).setZero();
  }
  return residual;
}

}  // namespace pipescout::estimation
