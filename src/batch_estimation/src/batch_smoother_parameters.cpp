// SPDX-License-Identifier: Apache-2.0
#include "pipescout/batch_estimation/batch_smoother.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {

using validation::check_within;

BatchSmootherParameters BatchSmootherParameters::like(const FixedLagSmootherParameters& online) {
  return {.gravity = online.gravity,
          .earth = online.earth,
          .max_held_imu = online.max_held_imu,
          .imu_noise = online.imu_noise,
          .coasting_acceleration = online.coasting_acceleration,
          .coasting_angular_rate = online.coasting_angular_rate,
          .coasting_turn = online.coasting_turn,
          .globals = online.globals,
          .global_deviations = online.global_deviations,
          .robustness = online.robustness};
}

void BatchSmootherParameters::validate() const {
  check_within("gravity", gravity, 0, 100);
  earth.validate();
  check_within("max_held_imu", max_held_imu, 0, 1);
  imu_noise.validate();
  check_within("coasting_acceleration", coasting_acceleration, 1e-6, 1000);
  check_within("coasting_angular_rate", coasting_angular_rate, 1e-6, 1000);
  check_within("coasting_turn", coasting_turn, 0, 1000);
  if (!globals.is_finite()) {
    validation::refuse("globals: one is not finite");
  }
  global_deviations.validate();
  for (const Robustness& one : robustness) {
    one.validate();
  }
  const auto solver = static_cast<double>(linear_solver);
  validation::require("linear_solver", solver,
                      solver <= static_cast<double>(LinearSolver::kSparseSchur),
                      "the linear solvers");
  check_within("max_iterations", max_iterations, 1, 10000);
  check_within("tolerance", tolerance, 1e-16, 1e-2);
  check_within("max_reintegrations", max_reintegrations, 0, 100);
}

}  // namespace pipescout::estimation
