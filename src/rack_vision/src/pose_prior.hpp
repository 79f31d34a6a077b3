// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "feature_system.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"

namespace pipescout::rack_vision {

/// Adds what the problem says beforehand of the pose and of the map's error, which hangs together
/// with it, to the normal equations at the state.
void add_pose_prior(const PoseProblem& problem, const SolverState& state,
                    const UnknownLayout& layout, SystemMatrix& information, SystemVector& gradient,
                    double& cost);

}  // namespace pipescout::rack_vision
