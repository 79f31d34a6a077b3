// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/estimation/visual_pose_factor.hpp"

namespace pipescout::estimation {

/// Pose of the body in the map, by motion capture, markers or another localizer: as a visual pose
/// with the rack at the origin of the map.
struct PoseMeasurement : VisualPoseMeasurement {
  using FactorType = class PoseFactor;
  /// Which of GlobalStates::own is its delay relative to the stamp, s; negative: it has none.
  int clock = -1;
};

[[nodiscard]] InputFault check(const PoseMeasurement& m) noexcept;

/// As VisualPoseFactor, with a pose of the rack of zero, and its own time offset.
class PoseFactor {
 public:
  static constexpr int kRows = VisualPoseFactor::kRows;
  explicit PoseFactor(const PoseMeasurement& measurement);
  [[nodiscard]] double time() const noexcept { return pose_.time(); }
  [[nodiscard]] InputFault fault() const noexcept;
  void identify(Fingerprint& fingerprint) const { pose_.identify(fingerprint); }
  [[nodiscard]] VisualPoseFactor::Residual evaluate(const NavState& x, const GlobalStates& globals,
                                                    Jacobians<kRows>* derivatives = nullptr) const;

 private:
  VisualPoseFactor pose_;
  int clock_;
};

}  // namespace pipescout::estimation
