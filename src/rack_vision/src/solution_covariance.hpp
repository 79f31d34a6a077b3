// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "feature_system.hpp"

namespace pipescout::rack_vision {

/// See `covariance_factor`: what it is for edges and for points when the stated sigmas are true.
struct CovarianceFactors {
  double edges = 1;
  double points = 1;
};

/// Fills in covariances, observability, offsets, intrinsics, scale and the status kOk or
/// kUnobserved. `prior`: information of all priors at the solution.
void describe_solution(const NormalEquations& equations, const SystemMatrix& prior,
                       const UnknownLayout& layout, const SolverState& state,
                       const CovarianceFactors& factors, const PoseSolverParameters& parameters,
                       PoseSolution& solution);

}  // namespace pipescout::rack_vision
