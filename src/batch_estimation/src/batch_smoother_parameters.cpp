// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "pipescout/batch_estimation/batch_smoother.hpp"

namespace pipescout::estimation {
namespace {

void within(const char* field, double value, double low, double high, const char* range) {
  if (!(value >= low && value <= high)) {
    std::ostringstream message;
    message << field << ": " << value << " is outside " << range;
    throw std::invalid_argument(message.str());
  }
}

}  // namespace

BatchSmootherParameters BatchSmootherParameters::like(const FixedLagSmootherParameters& online) {
  return {.gravity = online.gravity,
          .max_held_imu = online.max_held_imu,
          .imu_noise = online.imu_noise,
          .coasting_acceleration = online.coasting_acceleration,
          .coasting_angular_rate = online.coasting_angular_rate,
          .globals = online.globals,
          .global_deviations = online.global_deviations,
          .robustness = online.robustness};
}

void BatchSmootherParameters::validate() const {
  within("gravity", gravity, 0, 100, "[0, 100]");
  within("max_held_imu", max_held_imu, 0, 1, "[0, 1]");
  imu_noise.validate();
  within("coasting_acceleration", coasting_acceleration, 1e-6, 1000, "[1e-6, 1000]");
  within("coasting_angular_rate", coasting_angular_rate, 1e-6, 1000, "[1e-6, 1000]");
  if (!globals.is_finite()) {
    throw std::invalid_argument("globals: one is not finite");
  }
  global_deviations.validate();
  for (const Robustness& one : robustness) {
    one.validate();
  }
  within("linear_solver", static_cast<double>(linear_solver), 0,
         static_cast<double>(LinearSolver::kSparseSchur), "the linear solvers");
  within("max_iterations", max_iterations, 1, 10000, "[1, 10000]");
  within("tolerance", tolerance, 1e-16, 1e-2, "[1e-16, 1e-2]");
  within("max_reintegrations", max_reintegrations, 0, 100, "[0, 100]");
}

}  // namespace pipescout::estimation
