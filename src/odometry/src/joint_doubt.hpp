// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "joint_chain.hpp"
#include "pipescout/odometry/weld_positioning.hpp"
#include "weld_hypotheses.hpp"

namespace pipescout::odometry {

/// How sure it is which joint a place is in: near a weld a small error takes it into the next one.
class JointDoubt {
 public:
  JointDoubt(const WeldPositioningParameters& parameters, const JointChain& chain,
             std::span<const TallyBend> bends);

  /// A bend was found; m, of the odometer at its middle.
  void note_bend(double odometer_distance) noexcept { found_ = odometer_distance; }

  /// Probabilities that the place is not in the joint, [0, 1].
  struct Doubt {
    double total = 0.0;    ///< for any reason
    double by_bend = 0.0;  ///< by an odometer fault in a bend alone
  };
  /// `now`: in joint `joint`, when the odometer is at `odometer` (m).
  [[nodiscard]] Doubt doubt(const WeldHypothesis& now, int joint, double odometer) const noexcept;

 private:
  [[nodiscard]] bool bend_since_anchor(const WeldHypothesis& now, double odometer) const noexcept;

  const WeldPositioningParameters& parameters_;
  const JointChain& chain_;
  std::vector<double> bends_;  // m, middles from weld 0, along the pipe
  double found_;               // m, of the odometer: the middle of the last bend; NaN: none
};

}  // namespace pipescout::odometry
