// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/robust_kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace pipescout::estimation {
namespace {

constexpr RobustKernel kKernels[] = {RobustKernel::kNone, RobustKernel::kHuber,
                                     RobustKernel::kCauchy, RobustKernel::kSaliency};

TEST(RobustKernelTest, TheSlopeOfTheCostIsWeightTimesResidual) {
  constexpr double kStep = 1e-6;
  for (const RobustKernel kernel : kKernels) {
    for (const double width : {0.5, 1.0, 3.0}) {
      EXPECT_EQ(evaluate(kernel, 0, width).cost, 0);
      EXPECT_EQ(evaluate(kernel, 0, width).weight, 1);
      for (const double e : {0.1, 0.7, 1.3, 2.9, 20.0}) {
        const double slope =
            (evaluate(kernel, e + kStep, width).cost - evaluate(kernel, e - kStep, width).cost) /
            (2 * kStep);
        EXPECT_NEAR(slope, evaluate(kernel, e, width).weight * e, 1e-7)
            << to_string(kernel) << ' ' << e;
      }
    }
  }
}

TEST(RobustKernelTest, WeightsFallWithTheResidual) {
  for (const RobustKernel kernel : kKernels) {
    double before = 1;
    for (double e = 0; e < 100; e += 0.37) {
      const double weight = evaluate(kernel, e, 2).weight;
      EXPECT_LE(weight, before);
      EXPECT_GT(weight, 0);
      before = weight;
    }
  }
  // Equation (29), 1 / (nu + |e|), times nu.
  EXPECT_DOUBLE_EQ(evaluate(RobustKernel::kSaliency, 3, 1.5).weight, 1.5 / (1.5 + 3));
}

TEST(ChiSquareTest, QuantilesAreThoseOfTables) {
  // Abramowitz and Stegun, table 26.8.
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.84146, 1e-5);
  EXPECT_NEAR(chi_square_quantile(0.99, 2), 9.21034, 1e-5);
  EXPECT_NEAR(chi_square_quantile(0.999, 3), 16.266, 1e-3);
  EXPECT_NEAR(chi_square_quantile(0.95, 6), 12.5916, 1e-4);
  EXPECT_NEAR(chi_square_quantile(0.5, 15), 14.3389, 1e-4);
  for (int degrees = 1; degrees <= 20; ++degrees) {
    for (const double p : {0.001, 0.1, 0.9, 0.9999}) {
      EXPECT_NEAR(chi_square_probability(chi_square_quantile(p, degrees), degrees), p, 1e-9);
    }
  }
  EXPECT_THROW(static_cast<void>(chi_square_quantile(1, 3)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(chi_square_quantile(0.5, 0)), std::invalid_argument);
}

TEST(RobustnessTest, IsValidated) {
  EXPECT_NO_THROW(Robustness{}.validate());
  EXPECT_THROW(Robustness{.width = 0}.validate(), std::invalid_argument);
  EXPECT_THROW(Robustness{.gate_probability = 0}.validate(), std::invalid_argument);
  EXPECT_THROW(Robustness{.gate_probability = 1.1}.validate(), std::invalid_argument);
  EXPECT_THROW(Robustness{.width = std::numeric_limits<double>::quiet_NaN()}.validate(),
               std::invalid_argument);
  EXPECT_THROW(Robustness{.kernel = static_cast<RobustKernel>(9)}.validate(),
               std::invalid_argument);
  EXPECT_EQ(to_string(RobustKernel::kSaliency), "saliency");
  EXPECT_EQ(to_string(static_cast<RobustKernel>(9)), "unknown");
}

}  // namespace
}  // namespace pipescout::estimation
