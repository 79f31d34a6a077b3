// SPDX-License-Identifier: Apache-2.0
// Cost functions as Ceres sees them, along their manifolds, against differences.
#include "cost_functions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace pipescout::estimation {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct BlockUnderTest {
  std::vector<double> numbers;
  const ceres::Manifold* manifold;
};

VectorXd residual_of(const ceres::CostFunction& cost, const std::vector<BlockUnderTest>& blocks) {
  std::vector<const double*> parameters;
  for (const BlockUnderTest& block : blocks) {
    parameters.push_back(block.numbers.data());
  }
  VectorXd r(cost.num_residuals());
  EXPECT_TRUE(cost.Evaluate(parameters.data(), r.data(), nullptr));
  return r;
}

void expect_derivatives(const ceres::CostFunction& cost,
                        const std::vector<BlockUnderTest>& blocks) {
  ASSERT_EQ(cost.parameter_block_sizes().size(), blocks.size());
  std::vector<const double*> parameters;
  std::vector<RowMajor> ambient;
  std::vector<double*> jacobians;
  for (const BlockUnderTest& block : blocks) {
    parameters.push_back(block.numbers.data());
    ambient.emplace_back(cost.num_residuals(), block.manifold->AmbientSize());
  }
  for (RowMajor& one : ambient) {
    jacobians.push_back(one.data());
  }
  VectorXd r(cost.num_residuals());
  ASSERT_TRUE(cost.Evaluate(parameters.data(), r.data(), jacobians.data()));
  constexpr double kStep = 1e-6;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const ceres::Manifold& manifold = *blocks[b].manifold;
    RowMajor plus(manifold.AmbientSize(), manifold.TangentSize());
    ASSERT_TRUE(manifold.PlusJacobian(parameters[b], plus.data()));
    const MatrixXd analytic = ambient[b] * plus;
    MatrixXd numeric(analytic.rows(), analytic.cols());
    for (Eigen::Index i = 0; i < numeric.cols(); ++i) {
      const auto moved = [&](double step) {
        std::vector<BlockUnderTest> there = blocks;
        VectorXd delta = VectorXd::Zero(numeric.cols());
        delta[i] = step;
        EXPECT_TRUE(manifold.Plus(parameters[b], delta.data(), there[b].numbers.data()));
        return residual_of(cost, there);
      };
      numeric.col(i) = (moved(kStep) - moved(-kStep)) / (2 * kStep);
    }
    EXPECT_LT((analytic - numeric).cwiseAbs().maxCoeff(), 1e-6 * (1 + numeric.norm())) << b;
  }
}

class CostFunctionsTest : public testing::TestWithParam<std::uint64_t> {
 protected:
  double draw(double scale) { return std::normal_distribution<double>(0, scale)(engine_); }
  Vector3d vector(double scale) { return {draw(scale), draw(scale), draw(scale)}; }
  NavState state() {
    return {.R_map_body = geometry::SO3::exp(vector(0.5)),
            .position = vector(3),
            .velocity = vector(2),
            .gyro_bias = vector(0.05),
            .accelerometer_bias = vector(0.1)};
  }
  GlobalStates globals() {
    return {.odometer_scale = 1 + draw(0.1),
            .mount_yaw = draw(0.2),
            .mount_pitch = draw(0.2),
            .rack_position = vector(2),
            .R_map_rack = geometry::SO3::exp(vector(0.5)),
            .gps_lever_arm = vector(1),
            .gps_time_offset = draw(0.1),
            .visual_pose_time_offset = draw(0.1),
            .imu_scale = scale()};
  }
  ImuScale scale() {
    return ImuScale{}.retract(ImuScaleVector::NullaryExpr([&] { return draw(0.05); }));
  }
  ImuPreintegration motion() {
    ImuPreintegration sum(ImuMotion(vector(0.02), vector(0.1), scale()));
    for (int i = 0; i < 5; ++i) {
      sum.integrate(vector(0.5), vector(2) + Vector3d(0, 0, 9.81), 0.01, {});
    }
    return sum;
  }
  BlockUnderTest block(const NavState& x) {
    BlockUnderTest made{std::vector<double>(kStateNumbers), &states_};
    pack(x, made.numbers.data());
    return made;
  }
  BlockUnderTest block(const GlobalStates& x) {
    BlockUnderTest made{std::vector<double>(kGlobalNumbers), &some_globals_};
    pack(x, made.numbers.data());
    return made;
  }
  CarryingMotions motions() { return {.from = motion().motion(), .to = motion().motion()}; }

  std::mt19937_64 engine_{GetParam()};
  StateManifold states_;
  GlobalManifold some_globals_{{kOdometerScale, kMountYaw, kRackRotation, kRackRotation + 1,
                                kRackRotation + 2, kGpsLeverArm + 1, kGpsTimeOffset, kImuScale,
                                kImuScale + 5, kImuScale + 8, kImuScale + 10, kImuScale + 15}};
};

TEST_P(CostFunctionsTest, BetweenKeyframes) {
  const OdometerMeasurement factor{.from_time = 0,
                                   .to_time = 1,
                                   .distance = 1 + draw(0.3),
                                   .standard_deviation = 0.1,
                                   .across_deviation = 0.1,
                                   .sensor = vector(0.5)};
  const GlobalStates none;
  expect_derivatives(
      FactorCost(factor, motions(), 9.81, none, {.two_keyframes = true, .globals = true}),
      {block(state()), block(state()), block(globals())});
  expect_derivatives(FactorCost(factor, motions(), 9.81, none, {.globals = true}),
                     {block(state()), block(globals())});
  expect_derivatives(FactorCost(factor, motions(), 9.81, none, {}), {block(state())});
}

TEST_P(CostFunctionsTest, OfOneTime) {
  const GpsMeasurement gps{.time = 0,
                           .position = vector(3),
                           .covariance = 0.04 * Eigen::Matrix3d::Identity(),
                           .angular_rate = vector(0.5)};
  const GlobalStates none;
  expect_derivatives(FactorCost(gps, motions(), 9.81, none, {.globals = true}),
                     {block(state()), block(globals())});
  const NonHolonomicMeasurement rolling{.time = 0,
                                        .lateral_deviation = 0.1,
                                        .vertical_deviation = 0.2,
                                        .sensor = vector(0.5),
                                        .angular_rate = vector(0.5)};
  expect_derivatives(FactorCost(rolling, motions(), 9.81, none, {.globals = true}),
                     {block(state()), block(globals())});
  const VisualPoseMeasurement pose{.time = 0,
                                   .T_rack_body = geometry::SE3(geometry::SO3(), vector(1)),
                                   .covariance = 0.01 * geometry::Matrix6d::Identity()};
  expect_derivatives(FactorCost(pose, {}, 9.81, none, {.globals = true}),
                     {block(state()), block(globals())});
}

TEST_P(CostFunctionsTest, OfTheImuAndOfWhatIsKnownBeforehand) {
  const NavState from = state();
  const ImuPreintegration sum = motion();
  const NavState to = sum.motion().propagate(from, 9.81).retract(StateVector::NullaryExpr([&] {
    return draw(1e-3);
  }));
  const GlobalStates none;
  expect_derivatives(ImuCost(ImuFactor(sum, 9.81), none, true),
                     {block(from), block(to), block(globals())});
  expect_derivatives(ImuCost(ImuFactor(sum, 9.81), none, false), {block(from), block(to)});
  expect_derivatives(PriorCost(PriorFactor(state(), 0.01 * StateMatrix::Identity())),
                     {block(state())});
  expect_derivatives(GlobalPriorCost(globals(), GlobalVector::Constant(0.3),
                                     {kOdometerScale, kMountYaw, kRackRotation, kRackRotation + 1,
                                      kRackRotation + 2, kGpsLeverArm + 1, kGpsTimeOffset,
                                      kImuScale, kImuScale + 5, kImuScale + 10}),
                     {block(globals())});
}

TEST_P(CostFunctionsTest, ManifoldsComeBack) {
  const BlockUnderTest x = block(state());
  const BlockUnderTest y = block(state());
  StateVector between;
  std::vector<double> there(kStateNumbers);
  ASSERT_TRUE(states_.Minus(y.numbers.data(), x.numbers.data(), between.data()));
  ASSERT_TRUE(states_.Plus(x.numbers.data(), between.data(), there.data()));
  EXPECT_LT(unpack_state(there.data()).local(unpack_state(y.numbers.data())).norm(), 1e-12);
  const BlockUnderTest g = block(globals());
  VectorXd delta = VectorXd::NullaryExpr(some_globals_.TangentSize(), [&] { return draw(0.3); });
  VectorXd back(delta.size());
  std::vector<double> moved(kGlobalNumbers);
  ASSERT_TRUE(some_globals_.Plus(g.numbers.data(), delta.data(), moved.data()));
  ASSERT_TRUE(some_globals_.Minus(moved.data(), g.numbers.data(), back.data()));
  EXPECT_LT((back - delta).norm(), 1e-12);
  EXPECT_EQ(unpack_globals(moved.data()).mount_pitch, unpack_globals(g.numbers.data()).mount_pitch);
  // A step that is none is refused, and the solver takes a shorter one.
  delta[2] = std::nan("");
  EXPECT_FALSE(some_globals_.Plus(g.numbers.data(), delta.data(), moved.data()));
}

INSTANTIATE_TEST_SUITE_P(Seeds, CostFunctionsTest, testing::Range<std::uint64_t>(1, 11));

TEST(FactorCostTest, WhatIsUndefinedSaysNothing) {
  const HeadingMeasurement heading{.time = 0, .heading = 0, .standard_deviation = 0.1};
  const GlobalStates none;
  const FactorCost cost(heading, {}, 9.81, none, {});
  NavState up;
  up.R_map_body = geometry::SO3::about_y(-std::acos(0.0));
  StateBlock numbers;
  pack(up, numbers.data());
  const double* const parameters = numbers.data();
  double r = 1;
  StateBlock jacobian;
  jacobian.fill(1);
  double* jacobians = jacobian.data();
  EXPECT_TRUE(cost.Evaluate(&parameters, &r, &jacobians));
  EXPECT_EQ(r, 0);
  for (const double one : jacobian) {
    EXPECT_EQ(one, 0);
  }
}

TEST(KernelLossTest, IsTheKernelOfTheSmoother) {
  const KernelLoss loss(statistics::RobustKernel::kCauchy, 2);
  for (const double e : {0.1, 1.0, 5.0}) {
    double at[3];
    double after[3];
    constexpr double kStep = 1e-6;
    loss.Evaluate(e * e, at);
    loss.Evaluate(e * e + kStep, after);
    EXPECT_NEAR(at[1], (after[0] - at[0]) / kStep, 1e-6);
    EXPECT_EQ(at[1], evaluate(statistics::RobustKernel::kCauchy, e, 2).weight);
    EXPECT_EQ(at[2], 0);
  }
}

}  // namespace
}  // namespace pipescout::estimation
