// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/manipulation/arm_model.hpp"

namespace pipescout::manipulation::internal {

struct RateWeights {
  double rotation = 3;    ///< m/rad: of an error of the rotation against one of position
  double damping = 0.05;  ///< largest
  double least_manipulability = 0.02;  ///< from which on it is damped
};

/// Rates of the joints, rad/s, that move the camera by `twist` [linear; angular], in axes of the
/// camera, in least squares over J^T (J J^T + damping^2 I)^-1 with rows weighted. Damping is 0 in
/// postures with `manipulability` >= least, and grows to its largest where that is 0, by
/// damping^2 (1 - w / least)^2 (Nakamura and Hanafusa 1986, equation 30).
[[nodiscard]] JointVector resolved_rates(const Jacobian& jacobian, double manipulability,
                                         const geometry::Vector6d& twist,
                                         const RateWeights& weights) noexcept;

}  // namespace pipescout::manipulation::internal
