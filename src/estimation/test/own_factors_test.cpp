// SPDX-License-Identifier: Apache-2.0
// Factors of own kinds: derivatives against numeric ones, faults, and states that walk.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "heap_guard.hpp"
#include "pipescout/estimation/factors.hpp"
#include "pipescout/estimation/fixed_lag_smoother.hpp"
#include "pipescout/estimation/pose_factor.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::SO3;

class OwnFactorsTest : public testing::TestWithParam<std::uint64_t> {
 protected:
  double draw(double scale) { return std::normal_distribution<double>(0, scale)(engine_); }
  Vector3d vector(double scale) { return {draw(scale), draw(scale), draw(scale)}; }
  Matrix3d covariance() {
    const Matrix3d a = Matrix3d::NullaryExpr([&] { return draw(1); });
    return a * a.transpose() + 0.1 * Matrix3d::Identity();
  }

  void expect_derivatives(const AnyFactor& factor) {
    ASSERT_EQ(factor.fault(), InputFault::kNone);
    const NavState x = {.R_map_body = SO3::exp(vector(1)),
                        .position = vector(10),
                        .velocity = vector(2),
                        .gyro_bias = vector(0.1),
                        .accelerometer_bias = vector(0.1)};
    GlobalStates globals;
    globals.own = OwnVector::NullaryExpr([&] { return draw(0.3); });
    globals.rack_position = vector(5);
    globals.R_map_rack = SO3::exp(vector(0.5));
    globals.visual_pose_time_offset = draw(0.1);
    FactorValue value;
    factor.evaluate(x, x, globals, true, value);
    ASSERT_EQ(value.rows, factor.rows());
    constexpr double kStep = 1e-6;
    const auto slope = [&](const StateVector& by_state, const GlobalVector& by_globals) {
      FactorValue after;
      FactorValue before;
      factor.evaluate(x.retract(by_state), x, globals.retract(by_globals), false, after);
      factor.evaluate(x.retract(-by_state), x, globals.retract(-by_globals), false, before);
      return ((after.residual - before.residual) / (2 * kStep)).head(value.rows).eval();
    };
    const double rounding = 1e-6 * (1 + value.from.topRows(value.rows).norm());
    for (int i = 0; i < kStateSize; ++i) {
      const auto numeric = slope(kStep * StateVector::Unit(i), GlobalVector::Zero());
      EXPECT_LT((value.from.col(i).head(value.rows) - numeric).norm(), rounding) << "state " << i;
    }
    for (int i = 0; i < kGlobalSize; ++i) {
      const auto numeric = slope(StateVector::Zero(), kStep * GlobalVector::Unit(i));
      EXPECT_LT((value.globals.col(i).head(value.rows) - numeric).norm(), rounding)
          << "global " << i;
    }
    EXPECT_EQ(factor.uses_globals(), !value.globals.topRows(value.rows).isZero());
  }

  std::mt19937_64 engine_{GetParam()};
};

TEST_P(OwnFactorsTest, Derivatives) {
  expect_derivatives({PositionMeasurement{1, vector(10), covariance(), vector(1)}, own_kind(0)});
  expect_derivatives(
      {VelocityMeasurement{1, vector(2), covariance(), vector(1), vector(0.5)}, own_kind(0)});
  expect_derivatives(
      {BodyVelocityMeasurement{1, vector(2), covariance(), vector(1), vector(0.5)}, own_kind(0)});
  expect_derivatives({HeightMeasurement{1, draw(10), 0.3, vector(1), 3}, own_kind(0)});
  expect_derivatives(
      {RangeMeasurement{1, 20 + draw(3), 0.3, vector(20), vector(1), 7}, own_kind(0)});
  expect_derivatives({MagneticFieldMeasurement{1, vector(20), draw(0.3), 0.2, 0}, own_kind(0)});
  VisualPoseMeasurement pose = {.time = 1,
                                .T_rack_body = {SO3::exp(vector(0.5)), vector(10)},
                                .angular_rate = vector(0.5),
                                .camera = vector(0.5),
                                .mounting = 2};
  pose.covariance.diagonal().setConstant(0.1);
  pose.covariance.topLeftCorner<3, 3>() = covariance();
  expect_derivatives({pose, own_kind(0)});
  PoseMeasurement of_map;
  static_cast<VisualPoseMeasurement&>(of_map) = pose;
  expect_derivatives({of_map, own_kind(0)});
  of_map.clock = 1;
  expect_derivatives({of_map, own_kind(0)});
}

INSTANTIATE_TEST_SUITE_P(Seeds, OwnFactorsTest, testing::Range<std::uint64_t>(1, 21));

/// The residual at a state and the default global states.
double residual(const AnyFactor& factor, const NavState& x) {
  FactorValue value;
  factor.evaluate(x, x, {}, false, value);
  return value.residual[0];
}

TEST(OwnFactorTest, MagneticNorthIsTheDeclinationEastOfTheMapsYAxis) {
  constexpr double kDeclination = 0.1;
  // A body that heads north-west and is tilted; the field dips by 60 degrees.
  const NavState x = {.R_map_body = SO3::from_roll_pitch_yaw({0.2, -0.3, 0.75 * std::numbers::pi})};
  const Vector3d field(0.5 * std::sin(kDeclination), 0.5 * std::cos(kDeclination), -0.87);
  MagneticFieldMeasurement m{0, 4.8e-5 * (x.R_map_body.inverse() * field), kDeclination, 0.1};
  EXPECT_NEAR(residual({m, own_kind(0)}, x), 0, 1e-9);
  NavState turned = x;
  turned.R_map_body = SO3::about_z(0.05) * x.R_map_body;
  EXPECT_NEAR(residual({m, own_kind(0)}, turned), 0.5, 1e-9);
  m.field = x.R_map_body.inverse() * Vector3d(0, 1e-3, -1);
  EXPECT_TRUE(std::isnan(residual({m, own_kind(0)}, x)));
}

TEST(OwnFactorTest, HeightsOfTheStandardAtmosphere) {
  EXPECT_NEAR(pressure_height(101325), 0, 1e-9);
  EXPECT_NEAR(pressure_height(89874.6), 1000, 0.5);  // ISO 2533
  EXPECT_NEAR(pressure_height(26436.3), 10000, 5);
  EXPECT_TRUE(std::isnan(pressure_height(-1)));
}

TEST(OwnFactorTest, FaultsAreThoseOfTheNumbersAndTimes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto fault = [](const auto& m) { return AnyFactor(m, own_kind(0)).fault(); };
  EXPECT_EQ(fault(HeightMeasurement{0, 1, 0.3}), InputFault::kNone);
  EXPECT_EQ(fault(HeightMeasurement{nan, 1, 0.3}), InputFault::kNotFinite);
  EXPECT_EQ(fault(HeightMeasurement{0, nan, 0.3}), InputFault::kNotFinite);
  EXPECT_EQ(fault(HeightMeasurement{0, 1, 0}), InputFault::kBadCovariance);
  EXPECT_EQ(fault(HeightMeasurement{.standard_deviation = 1, .bias = kOwnSize}),
            InputFault::kNotFinite);
  const geometry::Matrix6d unit = geometry::Matrix6d::Identity();
  EXPECT_EQ(fault(VisualPoseMeasurement{.covariance = unit, .mounting = kOwnSize - kMountingSize}),
            InputFault::kNone);
  EXPECT_EQ(fault(VisualPoseMeasurement{.covariance = unit, .mounting = kOwnSize - 5}),
            InputFault::kNotFinite);
  EXPECT_EQ(fault(VisualPoseMeasurement{.covariance = unit, .camera = {nan, 0, 0}}),
            InputFault::kNotFinite);
  EXPECT_EQ(fault(RangeMeasurement{.range = nan, .standard_deviation = 1}), InputFault::kNotFinite);
  EXPECT_EQ(fault(VelocityMeasurement{}), InputFault::kBadCovariance);
  EXPECT_EQ(fault(PositionMeasurement{}), InputFault::kBadCovariance);
  EXPECT_EQ(fault(BodyVelocityMeasurement{}), InputFault::kBadCovariance);
  EXPECT_EQ(fault(MagneticFieldMeasurement{.standard_deviation = 1}), InputFault::kBadDirection);
  EXPECT_EQ(fault(RelativePoseMeasurement{.from_time = 1, .to_time = 1}), InputFault::kBadInterval);
  EXPECT_TRUE(std::isnan(
      residual({RangeMeasurement{.range = 1, .standard_deviation = 1}, own_kind(0)}, {})));
}

TEST(OwnFactorTest, CovariancesAreScaled) {
  AnyFactor factor(HeightMeasurement{0, -3, 1}, own_kind(0));
  factor.scale_covariance(4);
  FactorValue value;
  factor.evaluate({}, {}, {}, true, value);
  EXPECT_DOUBLE_EQ(value.residual[0], 1.5);
  EXPECT_DOUBLE_EQ(value.from(0, kPosition + 2), 0.5);
}

/// A body at rest at a known height, with a barometer whose bias drifts by 2 cm/s.
class WalkingBiasTest : public testing::Test {
 protected:
  static constexpr double kPeriod = 0.1;
  static constexpr double kDrift = 0.02;  // m/s
  static FixedLagSmootherParameters parameters(double walk) {
    FixedLagSmootherParameters parameters;
    parameters.lag = 1;
    parameters.global_deviations.own[2] = 1;
    parameters.own_walks[2] = walk;
    return parameters;
  }
  void run(FixedLagSmoother& smoother, int keyframes) {
    StateVector deviations = StateVector::Constant(1e-3);
    smoother.initialise(0, {}, deviations.cwiseAbs2().asDiagonal());
    for (int k = 1; k <= keyframes; ++k) {
      const double time = kPeriod * k;
      smoother.add(ImuSample{time - kPeriod, kPeriod, Vector3d::Zero(), Vector3d(0, 0, 9.81)});
      smoother.add(GpsMeasurement{time, Vector3d::Zero(), 1e-4 * Matrix3d::Identity()});
      smoother.add({HeightMeasurement{.time = time,
                                      .height = kDrift * time + noise_(engine_),
                                      .standard_deviation = 0.1,
                                      .bias = 2},
                    own_kind(3)});
      ASSERT_EQ(smoother.update(time).reset, ResetReason::kNone);
    }
  }
  static double deviation(const FixedLagSmoother& smoother) {
    return std::sqrt(smoother.global_covariance()(kOwnStates + 2, kOwnStates + 2));
  }
  std::mt19937 engine_{1};
  std::normal_distribution<double> noise_{0, 0.1};
};

TEST_F(WalkingBiasTest, IsFollowedAndOnlyThenItsCovarianceIsRight) {
  constexpr int kKeyframes = 600;
  constexpr double kEnd = kDrift * kPeriod * kKeyframes;  // 1.2 m
  FixedLagSmoother walking(parameters(0.05));
  run(walking, kKeyframes);
  EXPECT_LT(std::abs(walking.globals().own[2] - kEnd), 3 * deviation(walking));
  EXPECT_LT(deviation(walking), 0.1);
  // Without the walk it is the mean of all time, and sure of it.
  FixedLagSmoother constant(parameters(0));
  run(constant, kKeyframes);
  EXPECT_GT(std::abs(constant.globals().own[2] - kEnd), 3 * deviation(constant));
  EXPECT_LT(deviation(constant), 0.01);
}

TEST_F(WalkingBiasTest, WithoutMeasurementsItsVarianceGrowsByTheWalk) {
  FixedLagSmoother smoother(parameters(0.05));
  run(smoother, 300);
  int k = 300;
  const auto wait = [&](int keyframes) {
    for (const int last = k + keyframes; k < last; ++k) {
      smoother.add(ImuSample{kPeriod * k, kPeriod, Vector3d::Zero(), Vector3d(0, 0, 9.81)});
      smoother.update(kPeriod * (k + 1));
    }
  };
  wait(20);  // until all have left the lag
  const double before = std::pow(deviation(smoother), 2);
  const double value = smoother.globals().own[2];
  wait(100);
  // To within the steps of a quarter of the lag.
  EXPECT_NEAR(std::pow(deviation(smoother), 2) - before, 0.05 * 0.05 * 10, 0.05 * 0.05 * 0.5);
  EXPECT_NEAR(smoother.globals().own[2], value, 1e-6);
}

TEST_F(WalkingBiasTest, NothingIsAllocated) {
  FixedLagSmoother smoother(parameters(0.05));
  run(smoother, 30);
  const pipescout::test::HeapGuard guard;
  run(smoother, 60);
  EXPECT_EQ(guard.allocations(), 0U);
}

TEST(OwnStatesTest, AreValidated) {
  FixedLagSmootherParameters parameters;
  parameters.own_walks[1] = -1;
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  parameters = {};
  parameters.global_deviations.own[1] = std::nan("");
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  parameters = {};
  parameters.relinearisation.own[0] = 0;
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  EXPECT_EQ(to_string(own_kind(0)), "own_0");
  EXPECT_EQ(to_string(own_kind(15)), "own_15");
  EXPECT_EQ(to_string(static_cast<FactorKind>(kFactorKinds)), "unknown");
}

}  // namespace
}  // namespace pipescout::estimation
