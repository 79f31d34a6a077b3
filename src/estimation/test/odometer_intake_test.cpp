// SPDX-License-Identifier: Apache-2.0
#include "odometer_intake.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace pipescout::estimation {
namespace {

/// 2 m/s at 10 Hz, from `first` on.
void drive(OdometerIntake& intake, int first, int last, double zero = 0) {
  for (int i = first; i < last; ++i) {
    EXPECT_EQ(intake.add({0.1 * i, 0.2 * i - zero, 1e-4 * i}), Outcome::kWaiting);
  }
}

TEST(OdometerIntake, DistancesAreInterpolatedWithTheirVariance) {
  OdometerIntake intake({.deviation = 0.003, .share = 0.01});
  drive(intake, 0, 50);
  const auto moved = intake.between(1.03, 2.58);
  ASSERT_TRUE(moved);
  EXPECT_NEAR(moved->distance, 3.1, 1e-9);
  EXPECT_NEAR(moved->deviation, std::sqrt(1.55e-3 + 9e-6 + 0.031 * 0.031), 1e-9);
  EXPECT_FALSE(intake.between(4, 5));
  EXPECT_FALSE(intake.between(-1, 1));
  EXPECT_FALSE(intake.between(2, 2));
  EXPECT_TRUE(intake.between(4.8, 4.9));
  const auto motion = intake.motion(intake.newest(), 1);
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->speed, 2, 1e-9);
  EXPECT_NEAR(motion->acceleration, 0, 1e-9);
}

TEST(OdometerIntake, ReversingIsNegative) {
  OdometerIntake intake({});
  for (int i = 0; i < 20; ++i) {
    intake.add({0.1 * i, -0.1 * i, 1e-4 * i});
  }
  EXPECT_NEAR(intake.between(0.5, 1)->distance, -0.5, 1e-9);
}

TEST(OdometerIntake, NoDistanceOverAResetOrAGap) {
  OdometerIntake intake({});
  drive(intake, 0, 30);
  drive(intake, 30, 60, 6);
  EXPECT_FALSE(intake.between(2.85, 2.95));
  EXPECT_TRUE(intake.between(2.75, 2.85));
  EXPECT_TRUE(intake.between(3.05, 3.25));
  drive(intake, 70, 80, 6);
  EXPECT_FALSE(intake.between(5.8, 7.05));
}

TEST(OdometerIntake, AReadingThatItsNeighboursContradictIsLeftOut) {
  OdometerIntake intake({});
  drive(intake, 0, 10);
  intake.add({1.0, 12, 1e-3});
  EXPECT_DOUBLE_EQ(intake.newest(), 0.9) << "nobody bears it out";
  drive(intake, 11, 20);
  intake.add({2.0, -5, 2e-3});
  intake.add({2.1, 60, 2e-3});
  drive(intake, 22, 30);
  const auto moved = intake.between(0.95, 2.25);
  ASSERT_TRUE(moved);
  EXPECT_NEAR(moved->distance, 2.6, 1e-9);
  EXPECT_EQ(moved->left_out, 3U);
  EXPECT_EQ(intake.between(0.5, 0.9)->left_out, 0U);
  EXPECT_NEAR(intake.motion(intake.newest(), 2)->speed, 2, 1e-9);
}

/// One reading in five, as off as it likes: what moves is known all the same.
TEST(OdometerIntake, ManyWrongReadingsDoNotHideTheMotion) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  int known = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    OdometerIntake intake({.largest_speed = 5});
    for (int i = 0; i < 40; ++i) {
      const bool wrong = uniform(engine) < 0.2;
      const double by = 20 * uniform(engine) - 10;
      intake.add({0.05 * i, 0.1 * i + (wrong ? by + std::copysign(1.0, by) : 0.0), 0});
    }
    if (const auto motion = intake.motion(intake.newest(), 1)) {
      ++known;
      EXPECT_NEAR(motion->speed, 2, 1.5) << trial;
    }
  }
  EXPECT_GT(known, 900);
}

TEST(OdometerIntake, AResetIsBelievedWhenItIsBorneOut) {
  OdometerIntake intake({.largest_speed = 5});
  drive(intake, 0, 30);
  drive(intake, 30, 31, 6);
  EXPECT_DOUBLE_EQ(intake.newest(), 2.9);
  drive(intake, 31, 33, 6);
  EXPECT_DOUBLE_EQ(intake.newest(), 3.2);
  EXPECT_FALSE(intake.between(2.8, 3.1));
  EXPECT_TRUE(intake.between(3.05, 3.15));
}

TEST(OdometerIntake, StatusWidensOrForbids) {
  OdometerIntake intake({.deviation = 0.01, .share = 0, .no_consensus_factor = 10});
  intake.add({0, 0, 0});
  intake.add({0.1, 0.1, 0});
  intake.add({0.2, 0.2, 0, OdometerStatus::kNoConsensus});
  intake.add({0.3, 0.3, 0, OdometerStatus::kNoData});
  EXPECT_NEAR(intake.between(0, 0.1)->deviation, 0.01, 1e-12);
  EXPECT_NEAR(intake.between(0.1, 0.2)->deviation, 0.1, 1e-12);
  EXPECT_FALSE(intake.between(0.2, 0.3));
}

TEST(OdometerIntake, OrderDoesNotMatterAndMemoryIsBounded) {
  OdometerIntake intake({});
  EXPECT_EQ(intake.add({0.2, 0.4, 0}), Outcome::kWaiting);
  EXPECT_EQ(intake.add({0, 0, 0}), Outcome::kWaiting);
  EXPECT_EQ(intake.add({0.1, 0.2, 0}), Outcome::kWaiting);
  EXPECT_EQ(intake.add({0.1, 0.3, 0}), Outcome::kDuplicate);
  EXPECT_NEAR(intake.between(0.05, 0.15)->distance, 0.2, 1e-12);
  EXPECT_EQ(intake.add({0.3, std::numeric_limits<double>::quiet_NaN(), 0}), Outcome::kNotFinite);
  EXPECT_EQ(intake.add({0.3, 0, -1}), Outcome::kBadCovariance);
  drive(intake, 3, 4000);
  EXPECT_EQ(intake.add({0.25, 0, 0}), Outcome::kLate);
  EXPECT_TRUE(intake.between(399.0, 399.9));
}

}  // namespace
}  // namespace pipescout::estimation
