// SPDX-License-Identifier: Apache-2.0
#include "weld_background.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace pipescout::odometry {
namespace {

constexpr double kLength = 5000.0;
constexpr double kFloor = 1e-9;

/// Of exponential variables.
constexpr double median_of(double mean) {
  return mean * std::numbers::ln2;
}

TEST(RunningMedian, FollowsTheMedianWhereverItStarts) {
  for (const double start : {1e-6, 1.0, 1e6}) {
    std::mt19937_64 engine(1);
    std::exponential_distribution<double> draw(0.5);
    RunningMedian median(kLength, kFloor);
    median.start(start, 1.0);
    for (int i = 0; i < 100000; ++i) {
      median.update(draw(engine));
    }
    EXPECT_NEAR(median.value(), median_of(2.0), 0.05 * median_of(2.0)) << start;
  }
}

TEST(RunningMedian, OneStrongValueMovesItByOneStep) {
  RunningMedian median(kLength, kFloor);
  median.start(1.0, kLength);
  median.update(1e100);
  EXPECT_GT(median.value(), 1.0);
  EXPECT_LT(median.value(), 1.0 + 2.0 / kLength);
}

TEST(RunningMedian, StaysAboveItsFloor) {
  RunningMedian median(kLength, kFloor);
  median.start(0.0, 1.0);
  for (int i = 0; i < 100; ++i) {
    median.update(0.0);
  }
  EXPECT_EQ(median.value(), kFloor);
}

TEST(WeldBackground, LearnsEachOutputOnItsOwn) {
  std::mt19937_64 engine(2);
  std::exponential_distribution<double> draw(1.0);
  WeldBackground background(2, kLength, kFloor);
  const auto place = WeldBackground::place(1.4);
  for (int i = 0; i < 100000; ++i) {
    background.update(place, std::array{draw(engine), 100.0 * draw(engine)});
  }
  EXPECT_NEAR(background.median(place, 0), median_of(1.0), 0.05 * median_of(1.0));
  EXPECT_NEAR(background.median(place, 1), median_of(100.0), 0.05 * median_of(100.0));
  EXPECT_GT(background.age(place), 0.5 * kLength);
}

TEST(WeldBackground, LearnsHowTheNoiseFallsWithTheSamples) {
  std::mt19937_64 engine(3);
  std::exponential_distribution<double> draw(1.0);
  std::uniform_real_distribution<double> log_samples(0.0, 4.0);
  WeldBackground background(1, kLength, kFloor);
  for (int i = 0; i < 200000; ++i) {
    const double at = log_samples(engine);
    background.update(WeldBackground::place(at), std::array{draw(engine) / std::exp2(at)});
  }
  for (const double at : {0.5, 1.0, 2.0, 3.0, 3.5}) {
    const double expected = median_of(1.0 / std::exp2(at));
    EXPECT_NEAR(background.median(WeldBackground::place(at), 0), expected, 0.15 * expected) << at;
  }
}

TEST(WeldBackground, BeginsWithWhatIsKnown) {
  WeldBackground background(2, kLength, kFloor);
  const auto place = WeldBackground::place(2.5);
  EXPECT_FALSE(background.knows(place));
  background.begin(place, std::array{3.0, 0.0}, 100.0);
  EXPECT_TRUE(background.knows(place));
  EXPECT_EQ(background.median(place, 0), 3.0);
  EXPECT_EQ(background.median(place, 1), kFloor);
  EXPECT_EQ(background.age(place), 100.0);
}

TEST(WeldBackground, UnknownKnotsTakeOverFromTheNearest) {
  WeldBackground background(1, kLength, kFloor);
  background.begin(WeldBackground::place(2.0), std::array{1.0}, 1000.0);  // knots 2 and 3
  const auto above = WeldBackground::place(4.999);
  background.update(above, std::array{1e9});
  EXPECT_NEAR(background.median(above, 0), 4.0, 0.1);
  const auto below = WeldBackground::place(0.0);
  background.update(below, std::array{1e9});
  EXPECT_NEAR(background.median(below, 0), 4.0, 0.1);
}

TEST(WeldBackground, PlacesAreClampedToTheKnots) {
  for (const double log_samples : {-1e3, 1e3}) {
    WeldBackground background(1, kLength, kFloor);
    const auto place = WeldBackground::place(log_samples);
    background.update(place, std::array{1.0});
    EXPECT_TRUE(background.knows(place)) << log_samples;
  }
}

}  // namespace
}  // namespace pipescout::odometry
