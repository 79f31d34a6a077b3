// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>

#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::rack_vision {

void PoseSolverParameters::validate() const {
  using validation::check_above;
  using validation::check_within;
  constexpr double kHuge = 1e9;
  if (method > SolverMethod::kLippielloSaliency || kernel > statistics::RobustKernel::kTukey) {
    throw std::invalid_argument("method, kernel: none of their enumerators");
  }
  check_above("kernel_width", kernel_width, 0, kHuge);
  check_above("saliency_nu", saliency_nu, 0, kHuge);
  check_within("largest_edge_widening", largest_edge_widening, 1, kHuge);
  check_within("iterations", iterations, 1, 100);
  check_above("smallest_step", smallest_step, 0, kHuge);
  check_above("gate", gate, 0, kHuge);
  check_within("edge_bias_sigma", edge_bias_sigma, 0, kHuge);
  check_above("largest_position_deviation", largest_position_deviation, 0, kHuge);
  check_above("largest_rotation_deviation", largest_rotation_deviation, 0, kHuge);
  check_above("offset_freedom", offset_freedom, 0, kHuge);
  check_above("innovation_gate", innovation_gate, 0, kHuge);
  check_above("observed_deviation", observed_deviation, 0, kHuge);
}

std::string_view to_string(SolverMethod method) noexcept {
  switch (method) {
    case SolverMethod::kIterated:
      return "iterated";
    case SolverMethod::kLippielloLeastSquares:
      return "Lippiello and Cacace, least squares";
    case SolverMethod::kLippielloSaliency:
      return "Lippiello and Cacace, saliency";
  }
  return "unknown";
}

std::string_view to_string(PoseStatus status) noexcept {
  switch (status) {
    case PoseStatus::kOk:
      return "ok";
    case PoseStatus::kUnobserved:
      return "part of the pose is unobservable";
    case PoseStatus::kNotConverged:
      return "not converged";
    case PoseStatus::kTooFewInliers:
      return "too few inliers";
    case PoseStatus::kNoFeatures:
      return "no features";
    case PoseStatus::kBadInput:
      return "bad input";
  }
  return "unknown";
}

}  // namespace pipescout::rack_vision
