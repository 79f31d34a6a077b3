// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_world/localisation_errors.hpp"

#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

constexpr std::uint64_t kLocalisation = 3;  // what is drawn for

}  // namespace

void LocalisationErrorParameters::validate() const {
  validation::check_within("position_sigma", position_sigma, 0, 10);
  validation::check_within("heading_sigma", heading_sigma, 0, 1);
  validation::check_above("correlation_time", correlation_time, 0, 1e4);
  validation::check_within("white_share", white_share, 0, 10);
}

LocalisationErrors::LocalisationErrors(const LocalisationErrorParameters& parameters,
                                       std::uint64_t seed)
    : parameters_(parameters), draw_(seed, kLocalisation) {
  parameters_.validate();
  for (double& drift : drift_) {
    drift = draw_.normal();
  }
}

LocalisationErrors::Error LocalisationErrors::next(double dt) {
  const double keep = std::exp(-dt / parameters_.correlation_time);
  const double fresh = std::sqrt(1 - keep * keep);
  std::array<double, 3> errors{};
  for (std::size_t i = 0; i < drift_.size(); ++i) {
    drift_[i] = keep * drift_[i] + fresh * draw_.normal();
    errors[i] = drift_[i] + parameters_.white_share * draw_.normal();
  }
  return {.x = parameters_.position_sigma * errors[0],
          .y = parameters_.position_sigma * errors[1],
          .heading = parameters_.heading_sigma * errors[2]};
}

}  // namespace pipescout::simulation
