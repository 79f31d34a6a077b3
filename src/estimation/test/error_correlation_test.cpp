// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/error_correlation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace pipescout::estimation {
namespace {

using Eigen::Vector2d;

/// Errors of deviation 1: a share of their variance is a first-order Gauss-Markov process.
class Errors {
 public:
  Errors(std::uint64_t seed, double share, double correlation_time)
      : share_(share), correlation_time_(correlation_time), engine_(seed) {
    lasting_ = drawn();
  }
  Vector2d next(double step) {
    const double kept = correlation_time_ > 0 ? std::exp(-step / correlation_time_) : 0;
    lasting_ = kept * lasting_ + std::sqrt(1 - kept * kept) * drawn();
    return std::sqrt(share_) * lasting_ + std::sqrt(1 - share_) * drawn();
  }

 private:
  Vector2d drawn() { return {normal_(engine_), normal_(engine_)}; }

  double share_;
  double correlation_time_;
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_{};
  Vector2d lasting_ = Vector2d::Zero();
};

struct Case {
  double share = 0;
  double correlation_time = 0;  // s
  double period = 0;            // s
  double longest = 0;           // s, as stated
  double least_found = 0;       // s
  double most_found = 0;
};

TEST(ErrorCorrelationTest, FindsTheTimeWithinTheBounds) {
  // A share of the variance that lasts for T counts as that share of T.
  for (const Case& one :
       {Case{0, 0, 0.2, 20, 0, 0.3}, Case{0, 0, 0.04, 0.5, 0, 0.03}, Case{1, 1, 0.2, 20, 0.9, 1.6},
        Case{1, 5, 0.2, 60, 4, 15}, Case{0.5, 5, 0.2, 60, 2, 8}, Case{1, 60, 0.2, 60, 50, 60},
        Case{1, 60, 0.2, 20, 20, 20}, Case{0.3, 20, 0.2, 60, 5, 30}}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      Errors errors(seed, one.share, one.correlation_time);
      ErrorCorrelation correlation;
      for (double time = 0; time < 600; time += one.period) {
        correlation.add(time, errors.next(one.period));
      }
      SCOPED_TRACE(testing::Message()
                   << one.share << " for " << one.correlation_time << " s, every " << one.period
                   << " s, at most " << one.longest << " s, seed " << seed);
      const double found = correlation.time(0, one.longest);
      EXPECT_GE(found, one.least_found);
      EXPECT_LE(found, one.most_found);
      EXPECT_EQ(correlation.time(one.longest, one.longest), one.longest);
      EXPECT_GE(correlation.time(0.9 * one.longest, one.longest), 0.9 * one.longest);
    }
  }
}

TEST(ErrorCorrelationTest, TakesTheLongestUntilItKnowsBetter) {
  Errors errors(1, 0, 0);
  ErrorCorrelation correlation;
  EXPECT_EQ(correlation.time(0, 20), 20);
  double before = 20;
  for (double time = 0; time < 100; time += 0.2) {
    correlation.add(time, errors.next(0.2));
    const double found = correlation.time(0, 20);
    if (time < 2) {
      EXPECT_EQ(found, 20);
    }
    before = std::min(before, found);
  }
  EXPECT_LT(before, 1);
}

TEST(ErrorCorrelationTest, OutliersAndGapsMakeNoCorrelation) {
  Errors errors(2, 0, 0);
  ErrorCorrelation correlation;
  double time = 0;
  for (int i = 0; i < 3000; ++i) {
    time += i % 50 == 0 ? 5 : 0.2;
    const double size = i % 37 == 0 ? 30 : 1;
    correlation.add(time, size * errors.next(0.2));
    correlation.add(time, Vector2d(1e3, 1e3));  // not newer
    correlation.add(time + 0.1, Vector2d(NAN, 0));
  }
  EXPECT_LT(correlation.time(0, 20), 0.6);
}

}  // namespace
}  // namespace pipescout::estimation
