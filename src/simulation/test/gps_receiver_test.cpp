// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/gps_receiver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

/// Moves east at 2 m/s.
SE3 place(double time) {
  return {SO3::about_z(0.3), {2 * time, 5, 1}};
}

std::vector<GpsFix> record(const GpsParameters& parameters, double duration, std::uint64_t seed) {
  GpsReceiver receiver(parameters, seed);
  std::vector<GpsFix> fixes;
  while (receiver.due() < duration) {
    if (const auto fix = receiver.measure(place(receiver.due()))) {
      fixes.push_back(*fix);
    }
  }
  return fixes;
}

TEST(GpsReceiver, ErrorsHaveTheirDeviationsAndCorrelation) {
  const GpsParameters parameters{.period = 0.5,
                                 .white_deviation = {0.3, 0.4, 0.9},
                                 .correlated_deviation = {0.6, 0.5, 1.2},
                                 .correlation_time = 5,
                                 .antenna = {0.2, 0.1, 1}};
  const auto fixes = record(parameters, 20'000, 1);
  ASSERT_EQ(fixes.size(), 40'000U);
  const auto error = [&](std::size_t i) {
    return Vector3d(fixes[i].position - place(fixes[i].time) * parameters.antenna);
  };
  constexpr std::size_t kLag = 10;  // 5 s, its correlation time
  Vector3d variance = Vector3d::Zero();
  Vector3d lagged = Vector3d::Zero();
  const std::size_t count = fixes.size() - kLag;
  for (std::size_t i = 0; i < count; ++i) {
    variance += error(i).cwiseAbs2() / static_cast<double>(count);
    lagged += error(i).cwiseProduct(error(i + kLag)) / static_cast<double>(count);
  }
  const Vector3d white = parameters.white_deviation.cwiseAbs2();
  const Vector3d correlated = parameters.correlated_deviation.cwiseAbs2();
  // 20000 s hold 2000 independent pieces: 3 % of a variance.
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(variance[axis], white[axis] + correlated[axis], 0.13 * variance[axis]);
    EXPECT_NEAR(lagged[axis], correlated[axis] * std::exp(-1), 0.13 * variance[axis]);
  }
  EXPECT_LT((fixes[7].covariance.diagonal() - white - correlated).norm(), 1e-12);
}

TEST(GpsReceiver, FixesComeLateAndOutOfOrder) {
  const auto fixes = record({.period = 0.1, .latency = 0.05, .latency_spread = 0.3}, 200, 1);
  bool disordered = false;
  double sum = 0;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const double late = fixes[i].arrival - fixes[i].time;
    EXPECT_GE(late, 0.05 - 1e-9);
    EXPECT_LE(late, 0.35 + 1e-9);
    sum += late;
    disordered = disordered || (i > 0 && fixes[i].arrival < fixes[i - 1].arrival);
  }
  EXPECT_TRUE(disordered);
  EXPECT_NEAR(sum / static_cast<double>(fixes.size()), 0.2, 0.01);
}

TEST(GpsReceiver, AnOutageIsSilentAndChangesNothingElse) {
  const auto whole = record({}, 100, 4);
  const auto broken = record({.outages = {{.begin = 30, .duration = 40}}}, 100, 4);
  ASSERT_EQ(broken.size(), whole.size() - 200);
  for (const GpsFix& fix : broken) {
    EXPECT_TRUE(fix.time < 30 || fix.time >= 70);
  }
  EXPECT_EQ(broken.back().position, whole.back().position);
}

TEST(GpsReceiver, OutliersAreAsManyAndAsFarAsAskedFor) {
  const auto clean = record({}, 4000, 2);
  const auto fixes =
      record({.outlier_share = 0.2, .outlier_least = 20, .outlier_most = 40}, 4000, 2);
  std::size_t outliers = 0;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const double off = (fixes[i].position - clean[i].position).norm();
    if (fixes[i].kind == GpsFixKind::kOutlier) {
      ++outliers;
      EXPECT_GE(off, 20 - 1e-9);
      EXPECT_LE(off, 40 + 1e-9);
    } else {
      EXPECT_EQ(off, 0);
    }
    EXPECT_EQ(fixes[i].covariance, clean[i].covariance);
  }
  // Binomial, 20000 fixes: 4 deviations are 1.1 %.
  EXPECT_NEAR(static_cast<double>(outliers) / static_cast<double>(fixes.size()), 0.2, 0.0115);
}

TEST(GpsReceiver, ATrapStandsOrMovesAlong) {
  for (const bool moves : {false, true}) {
    const GpsTrap trap{.begin = 20, .duration = 30, .offset = {0, 700, 0}, .moves_along = moves};
    const auto fixes = record({.traps = {trap}}, 100, 3);
    for (const GpsFix& fix : fixes) {
      const bool trapped = fix.time >= 20 && fix.time < 50;
      EXPECT_EQ(fix.kind == GpsFixKind::kTrap, trapped);
      const double seen_from = trapped && !moves ? 20 : fix.time;
      const Vector3d expected = place(seen_from).translation() + Vector3d(0, trapped ? 700 : 0, 0);
      EXPECT_LT((fix.position - expected).norm(), 6);
    }
  }
}

TEST(GpsReceiver, RefusesNonsense) {
  EXPECT_THROW(GpsReceiver({.period = 0}, 1), std::invalid_argument);
  EXPECT_THROW(GpsReceiver({.latency = -1}, 1), std::invalid_argument);
  EXPECT_THROW(GpsReceiver({.white_deviation = {NAN, 0, 0}}, 1), std::invalid_argument);
  EXPECT_THROW(GpsReceiver({.white_deviation = {0, 1, 1}, .correlated_deviation = {0, 1, 1}}, 1),
               std::invalid_argument);
  EXPECT_THROW(GpsReceiver({.outlier_least = 5, .outlier_most = 2}, 1), std::invalid_argument);
  EXPECT_THROW(GpsReceiver({.outages = {{.begin = 0, .duration = -1}}}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
