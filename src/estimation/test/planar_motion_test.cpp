// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/planar_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace pipescout::estimation {
namespace {

TEST(PlanarMotion, ReadingsAreThoseOfACircle) {
  PlanarMotion motion({.gravity = 9.8, .step = 0.02});
  EXPECT_TRUE(motion.add(0.0, 2.0, 0.5).empty());
  const auto& readings = motion.add(0.1, 2.0, 0.5);
  ASSERT_EQ(readings.size(), 5U);
  EXPECT_DOUBLE_EQ(readings.front().time, 0.0);
  EXPECT_DOUBLE_EQ(readings.back().time, 0.08);
  for (const ImuReading& reading : readings) {
    EXPECT_DOUBLE_EQ(reading.specific_force.x(), 0.0);
    EXPECT_DOUBLE_EQ(reading.specific_force.y(), 1.0);  // centripetal
    EXPECT_DOUBLE_EQ(reading.specific_force.z(), 9.8);
    EXPECT_DOUBLE_EQ(reading.angular_rate.z(), 0.5);
  }
}

TEST(PlanarMotion, SpeedAndTurnChangeEvenly) {
  PlanarMotion motion({.step = 0.5});
  EXPECT_TRUE(motion.add(0.0, 1.0, 0.0).empty());
  const auto& readings = motion.add(1.0, 2.0, 1.0);
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_DOUBLE_EQ(readings[1].specific_force.x(), 1.0);
  EXPECT_DOUBLE_EQ(readings[1].angular_rate.z(), 0.5);
  EXPECT_DOUBLE_EQ(readings[1].specific_force.y(), 0.75);
}

TEST(PlanarMotion, NothingIsImpliedOverAGapOrBackwards) {
  PlanarMotion motion({.longest_gap = 0.5});
  EXPECT_TRUE(motion.add(0.0, 1.0, 0.0).empty());
  EXPECT_TRUE(motion.add(2.0, 1.0, 0.0).empty());
  EXPECT_TRUE(motion.add(1.0, 5.0, 0.0).empty());
  EXPECT_EQ(motion.add(2.02, 1.0, 0.0).size(), 1U);
}

TEST(PlanarMotion, RefusesWhatIsNotFinite) {
  PlanarMotion motion;
  EXPECT_THROW((void)motion.add(0.0, std::numeric_limits<double>::quiet_NaN(), 0.0),
               std::invalid_argument);
  EXPECT_THROW(PlanarMotion({.step = 0}), std::invalid_argument);
}

/// Wheels and GPS alone: a drive along a circle of 20 m, told by both without errors.
TEST(PlanarMotion, WheelsAndGpsAreEnough) {
  constexpr double kRadius = 20;
  constexpr double kSpeed = 2;
  constexpr double kRate = kSpeed / kRadius;
  auto parameters = StateEstimatorParameters::ground_robot();
  set_planar(parameters);
  StateEstimator estimator(parameters);
  PlanarMotion motion({.gravity = parameters.smoother.gravity});
  Eigen::Vector3d truth = Eigen::Vector3d::Zero();
  for (int i = 0; i <= 1200; ++i) {
    const double time = 0.05 * i;
    const double angle = kRate * time;
    truth = {kRadius * std::sin(angle), kRadius * (1 - std::cos(angle)), 0};
    for (const ImuReading& reading : motion.add(time, kSpeed, kRate)) {
      (void)estimator.add(reading);
    }
    (void)estimator.add(
        OdometerReading{.time = time, .distance = kSpeed * time, .variance = 1e-4 * kSpeed * time});
    if (i % 20 == 0) {
      GpsMeasurement fix{.time = time, .position = truth};
      fix.covariance.diagonal().setConstant(0.25);
      (void)estimator.add(fix);
    }
  }
  const auto estimate = estimator.estimate();
  ASSERT_TRUE(estimate && estimate->in_map);
  EXPECT_LT((estimate->state.position - truth).head<2>().norm(), 0.3);
  EXPECT_NEAR(estimate->state.velocity.norm(), kSpeed, 0.1);
}

}  // namespace
}  // namespace pipescout::estimation
