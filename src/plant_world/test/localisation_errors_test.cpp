// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_world/localisation_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace pipescout::simulation {
namespace {

TEST(LocalisationErrors, HaveTheirDeviationAndDriftSlowly) {
  LocalisationErrors errors({.position_sigma = 0.2, .white_share = 0}, 1);
  double squares = 0;
  double steps = 0;
  double last = errors.next(0.1).x;
  constexpr int kCount = 100'000;
  for (int i = 0; i < kCount; ++i) {
    const double x = errors.next(0.1).x;
    squares += x * x;
    steps += (x - last) * (x - last);
    last = x;
  }
  EXPECT_NEAR(std::sqrt(squares / kCount), 0.2, 0.02);
  // 2 sigma^2 (1 - exp(-dt / 20 s))
  EXPECT_NEAR(std::sqrt(steps / kCount), 0.2 * std::sqrt(2 * (1 - std::exp(-0.005))), 1e-3);
  EXPECT_THROW(LocalisationErrors({.heading_sigma = -1}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
