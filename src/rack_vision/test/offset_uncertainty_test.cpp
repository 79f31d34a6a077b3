// SPDX-License-Identifier: Apache-2.0
#include "offset_uncertainty.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drawn_rack.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kSigma = 0.01;    // m
constexpr double kPrecise = 1e-3;  // m: what an image tells of a pipe
constexpr double kFar = 30;        // m: what it does not tell

/// Covariance of the three movable pipes of `drawn_rack` by edges that tell the distances between
/// them, and where all lie together with this deviation.
OffsetMatrix by_edges(double together) {
  OffsetMatrix covariance = OffsetMatrix::Zero();
  covariance.block<3, 3>(1, 1).setConstant(together * together);
  covariance.block<3, 3>(1, 1).diagonal().array() += kPrecise * kPrecise;
  return covariance;
}

/// One sigma of the mean of all offsets, and of the difference of two.
double together(const OffsetUncertainty& uncertainty) {
  return std::sqrt(uncertainty.covariance().block<3, 3>(1, 1).mean());
}
double apart(const OffsetUncertainty& uncertainty) {
  const OffsetMatrix& c = uncertainty.covariance();
  return std::sqrt(c(1, 1) + c(2, 2) - 2 * c(1, 2));
}

TEST(OffsetUncertainty, OfAllPipesTogetherStaysWhereNoFixedPipeIsInView) {
  OffsetUncertainty uncertainty(test::drawn_rack(), kSigma);
  uncertainty.begin(by_edges(0.002));
  for (int i = 0; i < 100; ++i) {
    uncertainty.learn(by_edges(kFar), 1);
  }
  EXPECT_GT(together(uncertainty), kSigma);
  EXPECT_LT(apart(uncertainty), 0.3 * kPrecise);
}

TEST(OffsetUncertainty, FallsWhereFixedPipesTellIt) {
  OffsetUncertainty uncertainty(test::drawn_rack(), kSigma);
  uncertainty.begin(by_edges(0.002));
  for (int i = 0; i < 100; ++i) {
    uncertainty.learn(by_edges(0.005), 1);
  }
  EXPECT_LT(together(uncertainty), 0.001);
}

TEST(OffsetUncertainty, LearnsNothingFromAViewThatIsNotNew) {
  OffsetUncertainty uncertainty(test::drawn_rack(), kSigma);
  const OffsetMatrix before = uncertainty.covariance();
  uncertainty.learn(by_edges(0.005), 0);
  EXPECT_EQ(uncertainty.covariance(), before);
}

TEST(OffsetUncertainty, IsNoneOfPipesThatCannotMove) {
  OffsetUncertainty uncertainty(test::drawn_rack(), kSigma);
  uncertainty.widen(1);
  EXPECT_EQ(uncertainty.covariance()(0, 0), 0);
  const OffsetUncertainty fixed(test::drawn_rack(), 0);
  EXPECT_TRUE(fixed.covariance().isZero(0));
}

TEST(OffsetUncertainty, ReturnsForAPipeThatIsDoubted) {
  OffsetUncertainty uncertainty(test::drawn_rack(), kSigma);
  for (int i = 0; i < 100; ++i) {
    uncertainty.learn(by_edges(0.005), 1);
  }
  const double others = uncertainty.covariance()(1, 1);
  uncertainty.forget(2);
  EXPECT_DOUBLE_EQ(uncertainty.covariance()(2, 2), 2 * kSigma * kSigma);
  EXPECT_DOUBLE_EQ(uncertainty.covariance()(1, 1), others);
}

}  // namespace
}  // namespace pipescout::rack_vision
