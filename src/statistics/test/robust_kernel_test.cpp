// SPDX-License-Identifier: Apache-2.0
#include "pipescout/statistics/robust_kernel.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace pipescout::statistics {
namespace {

constexpr std::array kKernels{RobustKernel::kNone, RobustKernel::kSaliency, RobustKernel::kHuber,
                              RobustKernel::kCauchy, RobustKernel::kTukey};

TEST(RobustKernel, WeightAndSlopeFollowFromTheCost) {
  constexpr double kStep = 1e-6;
  for (const auto kernel : kKernels) {
    const double width = default_width(kernel);
    EXPECT_EQ(evaluate(kernel, 0, width).weight, 1);
    EXPECT_EQ(evaluate(kernel, 0, width).cost, 0);
    for (const double e : {0.1, 0.7, 1.3, 2.0, 3.0, 4.6, 8.0}) {
      const auto at = evaluate(kernel, e, width);
      const auto above = evaluate(kernel, e + kStep, width);
      const auto below = evaluate(kernel, e - kStep, width);
      EXPECT_NEAR((above.cost - below.cost) / (2 * kStep), at.weight * e, 1e-6);
      EXPECT_NEAR((above.weight * (e + kStep) - below.weight * (e - kStep)) / (2 * kStep), at.slope,
                  1e-6);
    }
  }
}

TEST(RobustKernel, SaliencyIsThatOfThePaper) {
  // Equation (29), s = 1 / (nu + |e|), is the weight but for the factor nu.
  for (const double e : {0.0, 1.0, 5.0}) {
    EXPECT_DOUBLE_EQ(evaluate(RobustKernel::kSaliency, e, 2).weight, 2 / (2 + e));
  }
}

TEST(RobustKernel, TukeyForgetsWhatIsFarAway) {
  EXPECT_EQ(evaluate(RobustKernel::kTukey, 5, 4.685).weight, 0);
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(evaluate(RobustKernel::kTukey, infinity, 4.685).weight, 0);
}

TEST(RobustKernel, EfficiencyOfTheUsualWidths) {
  // Asymptotic variance over that of least squares: factor over the mean weight. 95 % each.
  EXPECT_NEAR(covariance_factor(RobustKernel::kNone, 1, 1), 1, 1e-12);
  EXPECT_NEAR(covariance_factor(RobustKernel::kNone, 1, 2), 1, 1e-6);
  for (const auto kernel : {RobustKernel::kHuber, RobustKernel::kCauchy, RobustKernel::kTukey}) {
    const double factor = covariance_factor(kernel, default_width(kernel), 1);
    EXPECT_GT(factor, 0.5) << to_string(kernel);
    EXPECT_LT(factor, 1 / 0.95) << to_string(kernel);
  }
}

TEST(RobustKernel, WeightsFallWithTheResidual) {
  for (const auto kernel : kKernels) {
    double before = 1;
    for (double e = 0; e < 100; e += 0.37) {
      const double weight = evaluate(kernel, e, 2).weight;
      EXPECT_LE(weight, before) << to_string(kernel);
      before = weight;
    }
  }
}

TEST(RobustKernel, HasNames) {
  EXPECT_EQ(to_string(RobustKernel::kSaliency), "saliency");
  EXPECT_EQ(to_string(static_cast<RobustKernel>(9)), "unknown");
}

}  // namespace
}  // namespace pipescout::statistics
