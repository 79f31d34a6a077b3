// SPDX-License-Identifier: Apache-2.0
// A UAV whose estimator is started in the air, while it hovers in the wind or is on its way.
#include <gtest/gtest.h>

#include <cmath>

#include "pipescout/estimation_study/run_score.hpp"

namespace pipescout::estimation_study {
namespace {

class StartInTheAir : public testing::TestWithParam<std::uint64_t> {};

TEST_P(StartInTheAir, IsNotInTheMapBeforeItKnowsWhere) {
  const RunOptions options{.duration = 60, .in_flight = true};
  const VehicleRun run = uav_run(options, GetParam());
  const RunScore score =
      score_run(run, options, estimator_parameters(run, options), {.settling = 0});
  ASSERT_LT(score.started, 40);
  // Of 9 degrees of freedom: one in 10^9 is above it.
  constexpr double kImpossible = 60;
  for (const EstimateScore& estimate : score.estimates) {
    EXPECT_FALSE(estimate.nees > kImpossible) << "at " << estimate.time;
    EXPECT_LT(estimate.error.head<3>().norm(), 0.5) << "at " << estimate.time;
    EXPECT_LT(estimate.error.segment<3>(3).norm(), 0.5) << "at " << estimate.time;
  }
  EXPECT_EQ(score.status.last_restart, estimation::RestartReason::kNone);
}

INSTANTIATE_TEST_SUITE_P(Seeds, StartInTheAir, testing::Range<std::uint64_t>(1, 41));

}  // namespace
}  // namespace pipescout::estimation_study
