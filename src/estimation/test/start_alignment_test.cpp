// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/start_alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SO3;

/// Positions on a quarter of a circle of 10 m, 0.2 s apart.
Vector3d on_arc(int i) {
  const double angle = 0.01 * i;
  return {10 * std::sin(angle), 10 * (1 - std::cos(angle)), 0.02 * i};
}

TEST(Level, PutsTheSpecificForceUpright) {
  for (const Vector3d& rpy : {Vector3d(0.2, -0.3, 0), Vector3d(3, 0.1, 0), Vector3d(0, 1.5, 0)}) {
    const SO3 R = SO3::from_roll_pitch_yaw(rpy);
    const auto found = level(R.inverse() * Vector3d(0, 0, 9.81));
    ASSERT_TRUE(found);
    EXPECT_LT((found->inverse() * R).log().norm(), 1e-12);
  }
  EXPECT_FALSE(level(Vector3d::Zero()));
  EXPECT_FALSE(level(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())));
}

TEST(TrackAlignment, FindsYawAndOffsetOfATrack) {
  const SO3 turn = SO3::about_z(2.5);
  const Vector3d shift(1e5, -3e4, 70);
  TrackAlignment track;
  EXPECT_FALSE(track.solve(0.0));
  for (int i = 0; i < 157; ++i) {
    track.add(0.2 * i, turn * on_arc(i) + shift, on_arc(i), 0.5);
  }
  const auto found = track.solve();
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->yaw, 2.5, 1e-9);
  EXPECT_LT((found->offset - shift).norm(), 1e-6);
  EXPECT_NEAR(found->scale, 1, 1e-9);
  EXPECT_LT(found->chi_square, 1e-6);
  EXPECT_EQ(found->degrees, 2 * 157 - 4);
  EXPECT_NEAR(track.extent(), on_arc(156).head<2>().norm(), 1e-9);
  const auto known = track.solve(2.5);
  ASSERT_TRUE(known);
  EXPECT_LT((known->offset - shift).norm(), 1e-6);
  EXPECT_LT(known->chi_square, 1e-6);
  EXPECT_GT(track.solve(2.0)->chi_square, 1000);
}

TEST(TrackAlignment, APointSaysNothingOfTheYaw) {
  TrackAlignment track;
  for (int i = 0; i < 20; ++i) {
    track.add(i, Vector3d(5, 6, 7), Vector3d(1, 2, 3), 0.5);
  }
  EXPECT_DOUBLE_EQ(track.solve()->yaw_deviation, std::numbers::pi);
  EXPECT_LT((track.solve(0)->offset - Vector3d(4, 4, 4)).norm(), 1e-9);
}

TEST(TrackAlignment, DeviationsAreThoseOfTheErrors) {
  constexpr int kTracks = 300;
  double yaw = 0;
  double place = 0;
  double chi_square = 0;
  double drift = 0;
  for (int seed = 1; seed <= kTracks; ++seed) {
    std::mt19937_64 engine(static_cast<std::uint64_t>(seed));
    std::normal_distribution<double> normal;
    const auto noise = [&](double s) {
      return Vector3d(s * normal(engine), s * normal(engine), s * normal(engine));
    };
    TrackAlignment track(0.5);
    const Vector3d true_drift = noise(0.5);
    const SO3 turn = SO3::about_z(-1);
    for (int i = 0; i < 80; ++i) {
      track.add(0.2 * i, turn * on_arc(i) + 0.2 * i * true_drift + noise(0.4), on_arc(i), 0.4);
    }
    const auto found = track.solve();
    yaw += std::pow((found->yaw + 1) / found->yaw_deviation, 2);
    const Vector3d newest = SO3::about_z(found->yaw) * on_arc(79) + found->offset;
    const Vector3d truth = turn * on_arc(79) + 0.2 * 79 * true_drift;
    place += (newest - truth).head<2>().squaredNorm() / std::pow(found->offset_deviation, 2) / 2;
    drift += (found->drift - true_drift).head<2>().squaredNorm() /
             std::pow(found->drift_deviation, 2) / 2;
    chi_square += found->chi_square / found->degrees;
  }
  // Means of chi-squares: standard deviations of 0.08, 0.06 and less.
  EXPECT_NEAR(yaw / kTracks, 1, 0.3);
  EXPECT_LT(place / kTracks, 1.25);  // the deviation is that of the worse axis
  EXPECT_GT(place / kTracks, 0.5);
  EXPECT_LT(drift / kTracks, 1.25);
  EXPECT_GT(drift / kTracks, 0.4);
  EXPECT_NEAR(chi_square / kTracks, 1, 0.03);
}

TEST(TrackAlignment, TheScaleTellsTracksOfAnotherMotion) {
  TrackAlignment track;
  for (int i = 0; i < 100; ++i) {
    track.add(0.2 * i, 0.5 * on_arc(i), on_arc(i), 0.1);
  }
  const auto found = track.solve();
  EXPECT_NEAR(found->scale, 0.5, 1e-6);
  EXPECT_LT(found->scale_deviation, 0.05);
}

}  // namespace
}  // namespace pipescout::estimation
