// SPDX-License-Identifier: Apache-2.0
#include "../beacon_range.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <heap_guard.hpp>
#include <limits>
#include <pipescout/estimation/fixed_lag_smoother.hpp>
#include <random>

namespace {

using Eigen::Vector3d;
using namespace pipescout::estimation;

constexpr std::array<std::array<double, 3>, 4> kBeacons = {
    {{20, 0, 5}, {0, 30, 8}, {-25, -10, 3}, {5, -20, 12}}};
constexpr double kBias = 0.8;       // m
constexpr double kPeriod = 0.1;     // s
constexpr double kSpeed = 1;        // m/s
constexpr double kDeviation = 0.1;  // m

BeaconRange measured(double time, std::size_t beacon, const Vector3d& position, double error) {
  const Vector3d there(kBeacons[beacon].data());
  const Vector3d antenna(0.3, 0, 1);
  return {time, there, antenna, (position + antenna - there).norm() + kBias + error, kDeviation};
}

/// Drives along x with a wrong start and an unknown bias of the ranges.
class BeaconRangeTest : public testing::Test {
 protected:
  BeaconRangeTest() : smoother_(parameters()) {
    StateVector deviations;
    deviations << Vector3d::Constant(3), Vector3d::Constant(0.02), Vector3d::Constant(0.3),
        Vector3d::Constant(1e-4), Vector3d::Constant(1e-3);
    smoother_.initialise(
        0, {.position = Vector3d(1.5, -2, 1), .velocity = Vector3d(kSpeed + 0.2, 0, 0)},
        deviations.cwiseAbs2().asDiagonal());
  }
  static FixedLagSmootherParameters parameters() {
    FixedLagSmootherParameters parameters;
    parameters.global_deviations.own[0] = 2;  // m: one of them is a state
    return parameters;
  }
  static Vector3d truth(double time) { return {kSpeed * time, 0, 0}; }
  void drive(int keyframes, double gross_error = 0) {
    for (int k = 1; k <= keyframes; ++k) {
      const double time = kPeriod * ++step_;
      smoother_.add(ImuSample{time - kPeriod, kPeriod, Vector3d::Zero(), Vector3d(0, 0, 9.81)});
      for (std::size_t i = 0; i < kBeacons.size(); ++i) {
        const double at = time - 0.02 * static_cast<double>(i);
        const BeaconRange range = measured(at, i, truth(at), noise_(engine_) + gross_error);
        EXPECT_EQ(smoother_.add(AnyFactor(range, own_kind(0))), Outcome::kWaiting);
      }
      smoother_.update(time);
    }
  }
  [[nodiscard]] Vector3d error() const {
    const std::size_t newest = smoother_.keyframes() - 1;
    return smoother_.state(newest).position - truth(smoother_.time(newest));
  }
  [[nodiscard]] std::size_t count(Outcome outcome) const {
    return smoother_.counts(own_kind(0))[static_cast<std::size_t>(outcome)];
  }

  FixedLagSmoother smoother_;
  std::mt19937 engine_{1};
  std::normal_distribution<double> noise_{0, kDeviation};
  int step_ = 0;
};

TEST_F(BeaconRangeTest, DerivativesAreThoseOfTheResidual) {
  const NavState x = {.R_map_body = pipescout::geometry::SO3::exp(Vector3d(0.3, -0.2, 1)),
                      .position = Vector3d(1, 2, 3)};
  GlobalStates globals;
  globals.own[0] = 0.4;
  const BeaconRange range = measured(0, 1, Vector3d(1, 1, 1), 0);
  Jacobians<1> derivatives;
  range.evaluate(x, globals, &derivatives);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < kStateSize; ++i) {
    const StateVector step = kStep * StateVector::Unit(i);
    const double slope = (range.evaluate(x.retract(step), globals, nullptr)[0] -
                          range.evaluate(x.retract(-step), globals, nullptr)[0]) /
                         (2 * kStep);
    EXPECT_NEAR(derivatives.from(0, i), slope, 1e-6) << i;
  }
  for (int i = 0; i < kGlobalSize; ++i) {
    const GlobalVector step = kStep * GlobalVector::Unit(i);
    const double slope = (range.evaluate(x, globals.retract(step), nullptr)[0] -
                          range.evaluate(x, globals.retract(-step), nullptr)[0]) /
                         (2 * kStep);
    EXPECT_NEAR(derivatives.globals(0, i), slope, 1e-6) << i;
  }
}

TEST_F(BeaconRangeTest, FindsPositionAndBias) {
  EXPECT_GT(error().norm(), 2);
  drive(60);
  EXPECT_LT(error().norm(), 0.2);
  EXPECT_NEAR(smoother_.globals().own[0], kBias, 0.1);
  const double variance = smoother_.global_covariance()(kOwnStates, kOwnStates);
  EXPECT_GT(variance, 0);
  EXPECT_LT(std::sqrt(variance), 0.1);
  EXPECT_LT(std::abs(smoother_.globals().own[0] - kBias), 4 * std::sqrt(variance));
  EXPECT_EQ(count(Outcome::kAccepted), 240U);
}

TEST_F(BeaconRangeTest, GrossErrorsAreGated) {
  drive(60);
  drive(5, 10);
  EXPECT_EQ(count(Outcome::kGated), 20U);
  EXPECT_LT(error().norm(), 0.3);
}

TEST_F(BeaconRangeTest, TheSameMeasurementTwiceIsADuplicate) {
  const BeaconRange range = measured(0, 0, truth(0), 0);
  EXPECT_EQ(smoother_.add(AnyFactor(range, own_kind(0))), Outcome::kWaiting);
  EXPECT_EQ(smoother_.add(AnyFactor(range, own_kind(0))), Outcome::kDuplicate);
  EXPECT_EQ(smoother_.add(AnyFactor(measured(0, 1, truth(0), 0), own_kind(0))), Outcome::kWaiting);
}

TEST_F(BeaconRangeTest, WhatIsNotFiniteIsLeftOut) {
  BeaconRange nowhere = measured(0, 0, truth(0), 0);
  nowhere.range = std::numeric_limits<double>::quiet_NaN();
  smoother_.add(AnyFactor(nowhere, own_kind(0)));
  drive(1);
  EXPECT_EQ(count(Outcome::kQuarantined), 1U);
  nowhere.stamp = std::numeric_limits<double>::infinity();
  EXPECT_EQ(smoother_.add(AnyFactor(nowhere, own_kind(0))), Outcome::kNotFinite);
}

TEST_F(BeaconRangeTest, NothingIsAllocated) {
  drive(5);
  const pipescout::test::HeapGuard guard;
  drive(30);
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
