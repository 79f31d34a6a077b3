// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/elbow_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "pipescout/odometry_study/quantile.hpp"

namespace pipescout::odometry_study {
namespace {

ElbowScores run(const ElbowSettings& settings, std::size_t count, const char* name) {
  const ElbowScores scores = run_elbows(settings, 1, count);
  const auto percent = [&](std::size_t part) {
    return 100.0 * static_cast<double>(part) / static_cast<double>(count);
  };
  std::printf("%s: p50 %.4f p95 %.4f worst %.4f m, inside %.1f %%, found %.1f %%, others %.3f/km\n",
              name, quantile(scores.errors, 0.5), quantile(scores.errors, 0.95),
              quantile(scores.errors, 1.0), percent(scores.inside), percent(scores.found),
              1000.0 * static_cast<double>(scores.others) / scores.driven);
  return scores;
}

TEST(ElbowScore, OneRunIsReproducible) {
  EXPECT_EQ(run_elbow({}, 7).error, run_elbow({}, 7).error);
}

TEST(ElbowScore, BendsOfBothPipesAreMeasuredAndFound) {
  constexpr std::size_t kBends = 200;
  for (const double diameter : {0.3, 1.0}) {
    const auto scores =
        run({.pipe_diameter = diameter}, kBends, diameter < 0.5 ? "0.3 m" : "1.0 m");
    EXPECT_LE(quantile(scores.errors, 0.95), 0.025);
    EXPECT_GE(scores.inside, 90 * kBends / 100);
    EXPECT_GE(scores.found, 97 * kBends / 100);
  }
}

TEST(ElbowScore, TheConsensusIsNotMadeForBends) {
  const auto scores = run({.rule = odometry::FusionRule::kConsensus}, 100, "1.0 m, consensus");
  EXPECT_GT(quantile(scores.errors, 0.95), 0.1);
}

}  // namespace
}  // namespace pipescout::odometry_study
