// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/gaussian_noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace pipescout::tracking {
namespace {

double normal_distribution(double x) {
  return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

TEST(GaussianNoise, HasTheMomentsOfTheNormalDistribution) {
  constexpr std::size_t kDraws = 1'000'000;
  std::mt19937_64 engine(7);
  std::vector<float> noise(kDraws);
  draw_gaussian(engine, noise);
  double sums[4] = {};
  for (const float value : noise) {
    double power = 1;
    for (double& sum : sums) {
      power *= static_cast<double>(value);
      sum += power;
    }
  }
  const double root = std::sqrt(static_cast<double>(kDraws));
  // Within four standard deviations of a mean of so many.
  EXPECT_NEAR(sums[0] / kDraws, 0, 4 / root);
  EXPECT_NEAR(sums[1] / kDraws, 1, 4 * std::sqrt(2.0) / root);
  EXPECT_NEAR(sums[2] / kDraws, 0, 4 * std::sqrt(15.0) / root);
  EXPECT_NEAR(sums[3] / kDraws, 3, 4 * std::sqrt(96.0) / root);
}

TEST(GaussianNoise, IsDistributedNormally) {
  constexpr std::size_t kDraws = 200'000;
  std::mt19937_64 engine(8);
  std::vector<float> noise(kDraws);
  draw_gaussian(engine, noise);
  std::ranges::sort(noise);
  double farthest = 0;
  for (std::size_t i = 0; i < kDraws; ++i) {
    const double expected = normal_distribution(static_cast<double>(noise[i]));
    farthest = std::max({farthest, std::abs(expected - static_cast<double>(i) / kDraws),
                         std::abs(expected - static_cast<double>(i + 1) / kDraws)});
  }
  // Kolmogorov and Smirnov: exceeded by chance once in a hundred thousand seeds.
  EXPECT_LT(farthest, 2.47 / std::sqrt(static_cast<double>(kDraws)));
  EXPECT_GT(noise.back(), 4.0F) << "tails";
  EXPECT_LT(noise.front(), -4.0F);
}

TEST(GaussianNoise, NeighboursAreIndependent) {
  constexpr std::size_t kDraws = 500'000;
  std::mt19937_64 engine(9);
  std::vector<float> noise(kDraws);
  draw_gaussian(engine, noise);
  // The two of one pair are 64 apart.
  for (const std::size_t apart : {1U, 2U, 64U, 128U}) {
    double sum = 0;
    for (std::size_t i = 0; i + apart < kDraws; ++i) {
      sum += static_cast<double>(noise[i]) * static_cast<double>(noise[i + apart]);
    }
    EXPECT_NEAR(sum / kDraws, 0, 4 / std::sqrt(static_cast<double>(kDraws))) << apart;
  }
}

TEST(GaussianNoise, FillsAnyNumberAndIsRepeatable) {
  for (const std::size_t count : {0U, 1U, 2U, 63U, 64U, 65U, 127U, 128U, 129U, 1000U}) {
    std::vector<float> first(count + 1, 99.0F);
    std::vector<float> second(count + 1, 99.0F);
    std::mt19937_64 engine(count);
    draw_gaussian(engine, std::span(first).first(count));
    std::mt19937_64 again(count);
    draw_gaussian(again, std::span(second).first(count));
    EXPECT_EQ(first, second);
    EXPECT_EQ(first.back(), 99.0F) << "beyond the end";
    EXPECT_EQ(std::count(first.begin(), first.end() - 1, 99.0F), 0);
    EXPECT_TRUE(std::ranges::all_of(first, [](float value) { return std::isfinite(value); }));
  }
}

}  // namespace
}  // namespace pipescout::tracking
