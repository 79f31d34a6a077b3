// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/absolute_source_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;

/// A vehicle that goes 2 m/s along x; fixes at 5 Hz. The state is right, odom is the map.
class AbsoluteSourceWatchTest : public testing::Test {
 protected:
  static constexpr double kPeriod = 0.2;

  WatchedFix fix(const Vector3d& off = Vector3d::Zero()) {
    time_ += kPeriod;
    WatchedFix fix;
    fix.time = time_;
    fix.reckoned = fix.predicted = Vector3d(2 * time_, 0, 0);
    fix.measured = fix.reckoned + off;
    fix.deviation = 0.5;
    fix.predicted_deviation = 0.3;
    fix.way = 2 * time_;
    return fix;
  }
  Verdict judge(const Vector3d& off = Vector3d::Zero()) {
    const Verdict verdict = watch_.judge(fix(off));
    if (verdict == Verdict::kUse || verdict == Verdict::kAcquire) {
      watch_.note_accepted(time_, 2 * time_);
    }
    return verdict;
  }
  int until(Verdict wanted, const Vector3d& off, int most) {
    int n = 1;
    while (n < most && judge(off) != wanted) {
      ++n;
    }
    return n;
  }

  AbsoluteSourceWatch watch_{SourceWatchParameters{}};
  double time_ = 0;
};

TEST_F(AbsoluteSourceWatchTest, TakesErrorsForAsLongCorrelatedAsTheyAreAtMost) {
  SourceWatchParameters parameters{.correlation_time = 20, .shortest_correlation_time = 1};
  AbsoluteSourceWatch found(parameters);
  parameters.shortest_correlation_time = 20;
  AbsoluteSourceWatch fixed(parameters);
  EXPECT_EQ(found.correlation_time(), 20);
  for (int i = 0; i < 1000; ++i) {
    const double time = kPeriod * i;
    // Independent enough: no two that follow each other have much in common.
    const Eigen::Vector2d innovation(std::sin(2.1 * i), std::cos(2.1 * i));
    for (AbsoluteSourceWatch* watch : {&found, &fixed}) {
      watch->offer({.time = time, .deviation = 1}, 0, innovation);
      watch->note_accepted(time, 0);
    }
  }
  EXPECT_EQ(found.correlation_time(), 1);
  EXPECT_EQ(fixed.correlation_time(), 20);
  EXPECT_EQ(found.covariance_scale(kPeriod), covariance_factor(1, kPeriod));
  EXPECT_EQ(found.deviation_factor(), 1);
}

TEST_F(AbsoluteSourceWatchTest, BecomesTrustedWhenItsFixesAgree) {
  EXPECT_EQ(watch_.state(), SourceState::kAbsent);
  EXPECT_EQ(judge(), Verdict::kHold);
  EXPECT_EQ(watch_.state(), SourceState::kCandidate);
  EXPECT_EQ(until(Verdict::kAcquire, Vector3d::Zero(), 100), 5);  // the first is 1 s ago
  EXPECT_EQ(watch_.state(), SourceState::kTrusted);
  EXPECT_EQ(judge(), Verdict::kUse);
}

TEST_F(AbsoluteSourceWatchTest, IsAbsentAfterAnOutageAndCandidateAfterwards) {
  until(Verdict::kAcquire, Vector3d::Zero(), 100);
  watch_.expire(time_ + 4.9);
  EXPECT_EQ(watch_.state(), SourceState::kTrusted);
  watch_.expire(time_ + 5.1);
  EXPECT_EQ(watch_.state(), SourceState::kAbsent);
  time_ += 10;
  EXPECT_EQ(judge(), Verdict::kHold);
  EXPECT_EQ(watch_.state(), SourceState::kCandidate);
}

TEST_F(AbsoluteSourceWatchTest, IsDoubtedAfterGatedOnesInARowOnly) {
  until(Verdict::kAcquire, Vector3d::Zero(), 100);
  for (std::size_t i = 0; i + 1 < SourceWatchParameters{}.doubt_after; ++i) {
    watch_.note_gated();
  }
  judge();
  EXPECT_EQ(watch_.state(), SourceState::kTrusted);
  for (std::size_t i = 0; i < SourceWatchParameters{}.doubt_after; ++i) {
    watch_.note_gated();
  }
  EXPECT_EQ(watch_.state(), SourceState::kDoubted);
  EXPECT_LE(until(Verdict::kAcquire, Vector3d::Zero(), 100), 7);
}

TEST_F(AbsoluteSourceWatchTest, FixesThatDoNotAgreeWithTheMotionAreNeverTaken) {
  for (int i = 0; i < 2000; ++i) {
    const WatchedFix moving = fix();
    WatchedFix standing = moving;
    standing.measured = Vector3d(0, 100, 0);  // while the vehicle moves
    EXPECT_EQ(watch_.judge(standing), Verdict::kHold);
  }
}

TEST_F(AbsoluteSourceWatchTest, AClusterOutOfReachTakesOverAfterItsTimeOnly) {
  const Vector3d off(0, 700, 0);
  const int needed = until(Verdict::kTakeOver, off, 2000);
  EXPECT_NEAR(needed * kPeriod, SourceWatchParameters{}.takeover, 1);
}

TEST_F(AbsoluteSourceWatchTest, AStateThatWasBorneOutWithstandsLonger) {
  int n = 0;
  WatchedFix wrong;
  do {
    wrong = fix({0, 700, 0});
    wrong.borne_out = 100;
    ++n;
  } while (watch_.judge(wrong) != Verdict::kTakeOver && n < 10000);
  EXPECT_NEAR(n * kPeriod, SourceWatchParameters{}.confirmed_takeover, 1);
}

TEST_F(AbsoluteSourceWatchTest, WhatAnotherSourceContestsNeverTakesOver) {
  for (int i = 0; i < 5000; ++i) {
    WatchedFix wrong = fix({0, 700, 0});
    wrong.contested = true;
    EXPECT_EQ(watch_.judge(wrong), Verdict::kHold);
  }
}

TEST_F(AbsoluteSourceWatchTest, ReachGrowsWithTheWay) {
  until(Verdict::kAcquire, Vector3d::Zero(), 100);
  time_ += 500;  // 1000 m
  WatchedFix back = fix({0, 20, 0});
  EXPECT_NEAR(watch_.drift(back), 10, 0.1);
  EXPECT_LT(until(Verdict::kAcquire, {0, 20, 0}, 100), 10);
}

TEST_F(AbsoluteSourceWatchTest, OneOutlierDoesNotBreakACandidate) {
  for (int i = 0; i < 3; ++i) {
    judge();
  }
  EXPECT_EQ(judge({500, 0, 0}), Verdict::kHold);
  EXPECT_LE(until(Verdict::kAcquire, Vector3d::Zero(), 100), 3);
}

TEST_F(AbsoluteSourceWatchTest, ACandidateThatBeginsWithAnOutlierIsGivenUp) {
  judge({500, 0, 0});
  EXPECT_LE(until(Verdict::kAcquire, Vector3d::Zero(), 100), 12);
}

TEST(SourceWatchParametersTest, OutOfRangeIsRefused) {
  SourceWatchParameters p;
  EXPECT_NO_THROW(p.validate());
  p.gate_probability = 1;
  EXPECT_THROW(p.validate(), std::invalid_argument);
  p = {};
  p.takeover = 0;
  EXPECT_THROW(AbsoluteSourceWatch{p}, std::invalid_argument);
}

TEST(CovarianceFactorTest, IsThatOfAMeanOfCorrelatedErrors) {
  EXPECT_EQ(covariance_factor(0, 0.1), 1);
  EXPECT_NEAR(covariance_factor(0.1, 10), 1, 1e-9);      // long apart
  EXPECT_NEAR(covariance_factor(1000, 0.1), 2e4, 1e-3);  // all within the correlation time: one
  // Variance of the mean of n of them against that of white ones, summed up.
  constexpr double kTime = 0.7;
  constexpr double kSpacing = 0.2;
  constexpr int kCount = 4000;
  double sum = 0;
  for (int lag = 1 - kCount; lag < kCount; ++lag) {
    sum += (1 - std::abs(lag) / static_cast<double>(kCount)) *
           std::exp(-std::abs(lag) * kSpacing / kTime);
  }
  EXPECT_NEAR(covariance_factor(kTime, kSpacing), sum, 0.01);
}

}  // namespace
}  // namespace pipescout::estimation
