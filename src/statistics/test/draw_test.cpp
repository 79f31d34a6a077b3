// SPDX-License-Identifier: Apache-2.0
#include "pipescout/statistics/draw.hpp"

#include <gtest/gtest.h>

namespace pipescout::statistics {
namespace {

constexpr std::uint64_t kSeed = 5;
constexpr int kDraws = 100000;

/// Of a draw, by its first two moments.
template <typename Sample>
void expect_moments(Sample sample, double mean, double variance) {
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = sample() - mean;
    sum += x;
    squares += x * x;
  }
  // Five deviations of the mean; the variance of these squares is below 10 variances squared.
  EXPECT_NEAR(sum / kDraws, 0, 5 * std::sqrt(variance / kDraws));
  EXPECT_NEAR(squares / kDraws, variance, 5 * variance * std::sqrt(10.0 / kDraws));
}

TEST(Draw, HasTheMomentsOfItsDistribution) {
  Engine engine = make_engine(kSeed, 1);
  expect_moments([&] { return uniform(engine, -1, 3); }, 1, 16.0 / 12);
  expect_moments([&] { return normal(engine); }, 0, 1);
  expect_moments([&] { return exponential(engine); }, 1, 1);
}

TEST(Draw, StaysInItsRange) {
  Draw draw(kSeed, 2);
  for (int i = 0; i < kDraws; ++i) {
    const double x = draw.uniform(2, 3);
    ASSERT_GE(x, 2);
    ASSERT_LT(x, 3);
    ASSERT_LT(draw.index(7), 7U);
    ASSERT_NEAR(draw.direction().norm(), 1, 1e-12);
  }
}

TEST(Draw, IsTheSameEverywhere) {
  // By the engine alone, which the C++ standard fixes.
  Engine engine(kSeed);
  const std::uint64_t first = Engine(kSeed)();
  EXPECT_EQ(uniform(engine), static_cast<double>(first >> 11U) * 0x1p-53);
}

TEST(Draw, PurposesAndSeedsHaveNothingToDoWithEachOther) {
  EXPECT_NE(make_engine(kSeed, 1)(), make_engine(kSeed, 2)());
  EXPECT_NE(make_engine(kSeed, 1)(), make_engine(kSeed + 1, 1)());
  EXPECT_EQ(make_engine(kSeed, 1)(), make_engine(kSeed, 1)());
}

TEST(Draw, HappensAsOftenAsItIsTold) {
  Draw draw(kSeed, 3);
  int hits = 0;
  for (int i = 0; i < kDraws; ++i) {
    hits += draw.happens(0.2) ? 1 : 0;
  }
  EXPECT_NEAR(hits, 0.2 * kDraws, 5 * std::sqrt(0.16 * kDraws));
}

}  // namespace
}  // namespace pipescout::statistics
