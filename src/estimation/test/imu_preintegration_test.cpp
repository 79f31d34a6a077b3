// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "dual.hpp"
#include "pipescout/estimation/imu_preintegration.hpp"
#include "pipescout/estimation/imu_timeline.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SO3;

constexpr double kGravity = 9.81;

struct Sample {
  Vector3d rate;
  Vector3d force;
};

constexpr double kSampleTime = 0.005;

class ImuTest : public testing::TestWithParam<int> {
 protected:
  double draw(double scale) { return std::normal_distribution<double>(0, scale)(engine_); }
  Vector3d vector(double scale) { return {draw(scale), draw(scale), draw(scale)}; }
  std::vector<Sample> samples(std::size_t count) {
    std::vector<Sample> all(count);
    for (Sample& s : all) {
      s = {vector(1), Vector3d(0, 0, kGravity) + vector(2)};
    }
    return all;
  }
  NavState state() {
    return {.R_map_body = SO3::exp(vector(1)),
            .position = vector(10),
            .velocity = vector(2),
            .gyro_bias = vector(0.02),
            .accelerometer_bias = vector(0.1)};
  }
  ImuScale scale() {
    return ImuScale{}.retract(ImuScaleVector::NullaryExpr([&] { return draw(0.05); }));
  }
  std::mt19937_64 engine_{static_cast<std::uint64_t>(GetParam())};
};

ImuMotion motion_of(const std::vector<Sample>& samples, const Vector3d& gyro_bias,
                    const Vector3d& accelerometer_bias, const ImuScale& scale) {
  ImuMotion motion(gyro_bias, accelerometer_bias, scale);
  for (const Sample& s : samples) {
    motion.integrate(s.rate, s.force, kSampleTime);
  }
  return motion;
}

ImuPreintegration preintegration_of(const std::vector<Sample>& samples, const NavState& x,
                                    const ImuScale& scale, const ImuNoise& noise) {
  ImuPreintegration sum(ImuMotion(x.gyro_bias, x.accelerometer_bias, scale));
  for (const Sample& s : samples) {
    sum.integrate(s.rate, s.force, kSampleTime, noise);
  }
  return sum;
}

Eigen::Matrix<double, 9, 1> difference(const ImuMotion& a, const ImuMotion& b) {
  Eigen::Matrix<double, 9, 1> d;
  d << b.position() - a.position(), (a.rotation().inverse() * b.rotation()).log(),
      b.velocity() - a.velocity();
  return d;
}

TEST_P(ImuTest, ScaleDerivativesAreThoseOfIntegratingAgain) {
  const auto all = samples(40);
  const Vector3d gyro = vector(0.05);
  const Vector3d force = vector(0.2);
  const ImuScale mean = scale();
  const ImuMotion motion = motion_of(all, gyro, force, mean);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kImuScaleSize; ++i) {
    const ImuScaleVector step = kStep * ImuScaleVector::Unit(i);
    const ImuMotion above = motion_of(all, gyro, force, mean.retract(step));
    const ImuMotion below = motion_of(all, gyro, force, mean.retract(-step));
    const Eigen::Matrix<double, 9, 1> slope =
        (difference(motion, above) - difference(motion, below)) / (2 * kStep);
    EXPECT_LT((slope - motion.scale_jacobian().col(i)).norm(), 1e-7) << i;
  }
}

TEST_P(ImuTest, AnImuWithErrorsOfScaleIsAsGoodAsOneWithoutOnceTheyAreKnown) {
  auto all = samples(40);
  const Vector3d gyro = vector(0.05);
  const Vector3d force = vector(0.2);
  const ImuMotion right = motion_of(all, Vector3d::Zero(), Vector3d::Zero(), {});
  const ImuScale known = scale();
  for (Sample& s : all) {
    s = {known.gyro.inverse() * s.rate + gyro, known.accelerometer.inverse() * s.force + force};
  }
  EXPECT_LT(difference(right, motion_of(all, gyro, force, known)).norm(), 1e-10);
  // Learnt afterwards, to first order.
  const ImuMotion late = motion_of(all, gyro, force, ImuScale{});
  const NavState start{.gyro_bias = gyro, .accelerometer_bias = force};
  const NavState end = right.propagate({}, kGravity);
  const auto error = [&](const ImuScale& scale) {
    return end.local(late.propagate(start, scale, kGravity)).head<9>().norm();
  };
  EXPECT_LT(error(known), 0.1 * error({}));
}

TEST_P(ImuTest, BiasDerivativesAreThoseOfIntegratingAgain) {
  const auto all = samples(40);
  const Vector3d gyro = vector(0.05);
  const Vector3d force = vector(0.2);
  const ImuScale fixed = scale();
  const ImuMotion motion = motion_of(all, gyro, force, fixed);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 6; ++i) {
    Eigen::Matrix<double, 6, 1> step = Eigen::Matrix<double, 6, 1>::Zero();
    step[i] = kStep;
    const ImuMotion above = motion_of(all, gyro + step.head<3>(), force + step.tail<3>(), fixed);
    const ImuMotion below = motion_of(all, gyro - step.head<3>(), force - step.tail<3>(), fixed);
    const Eigen::Matrix<double, 9, 1> slope =
        (difference(motion, above) - difference(motion, below)) / (2 * kStep);
    EXPECT_LT((slope - motion.bias_jacobian().col(i)).norm(), 1e-7) << i;
  }
}

TEST_P(ImuTest, PropagationHasItsDerivative) {
  const ImuMotion motion = motion_of(samples(20), vector(0.02), vector(0.1), scale());
  const NavState start = state();
  const ImuScale other =
      motion.scale().retract(ImuScaleVector::NullaryExpr([&] { return draw(0.01); }));
  StateMatrix analytic;
  ImuMotion::ScaleJacobian by_scale;
  const NavState end = motion.propagate(start, other, kGravity, &analytic, &by_scale);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kStateSize; ++i) {
    const StateVector step = kStep * StateVector::Unit(i);
    const StateVector slope = (end.local(motion.propagate(start.retract(step), other, kGravity)) -
                               end.local(motion.propagate(start.retract(-step), other, kGravity))) /
                              (2 * kStep);
    EXPECT_LT((slope - analytic.col(i)).norm(), 1e-7) << i;
  }
  for (int i = 0; i < kImuScaleSize; ++i) {
    const ImuScaleVector step = kStep * ImuScaleVector::Unit(i);
    const StateVector slope = (end.local(motion.propagate(start, other.retract(step), kGravity)) -
                               end.local(motion.propagate(start, other.retract(-step), kGravity))) /
                              (2 * kStep);
    EXPECT_LT((slope.head<9>() - by_scale.col(i)).norm(), 1e-7) << i;
    EXPECT_EQ(slope.tail<6>().norm(), 0) << i;
  }
}

TEST_P(ImuTest, FactorIsItsFormula) {
  const auto all = samples(20);
  const NavState from = state();
  NavState integrated = from;  // with other biases than those of `from`
  integrated.gyro_bias += vector(0.02);
  integrated.accelerometer_bias += vector(0.1);
  const ImuScale integrated_scale = scale();
  const GlobalStates globals{.imu_scale = scale()};
  const auto sum = preintegration_of(all, integrated, integrated_scale, {});
  const ImuFactor factor(sum, kGravity);
  const NavState to = sum.motion().propagate(from, kGravity).retract(StateVector::NullaryExpr([&] {
    return draw(0.1);
  }));
  Jacobians<15> derivatives;
  const StateVector residual = factor.evaluate(from, to, globals, &derivatives);

  using test::constant;
  using test::Dual;
  using test::Dual3;
  const test::DualState i(from, test::kFromPlace);
  const test::DualState j(to, test::kToPlace);
  const ImuMotion& motion = sum.motion();
  const Dual3 gyro = i.gyro_bias - constant(motion.gyro_bias());
  const Dual3 force = i.accelerometer_bias - constant(motion.accelerometer_bias());
  const test::DualGlobals scaled(globals);
  const auto corrected = [&](int row) {
    Dual3 sum_of = constant(Eigen::Matrix3d(motion.bias_jacobian().block<3, 3>(row, 0))) * gyro +
                   constant(Eigen::Matrix3d(motion.bias_jacobian().block<3, 3>(row, 3))) * force;
    for (int axis = 0; axis < 3; ++axis) {  // a row of the scale
      const auto a = static_cast<std::size_t>(axis);
      const auto by = [&](int column) {
        return constant(
            Eigen::Matrix3d(motion.scale_jacobian().block<3, 3>(row, column + 3 * axis)));
      };
      sum_of =
          sum_of +
          by(0) * (scaled.gyro_scale[a] - constant(Vector3d(integrated_scale.gyro.row(axis)))) +
          by(9) * (scaled.accelerometer_scale[a] -
                   constant(Vector3d(integrated_scale.accelerometer.row(axis))));
    }
    return sum_of;
  };
  const double t = motion.duration();
  const auto to_body = transpose(i.r);
  const Dual3 fall = constant(Vector3d(0, 0, -kGravity * t));
  const Dual3 moved = to_body * (j.p - i.p - Dual(t) * i.v - Dual(0.5 * t) * fall) -
                      (constant(motion.position()) + corrected(0));
  const auto turned = constant(motion.rotation().matrix()) * test::rotation(corrected(3));
  const Dual3 angle = log(transpose(turned) * (to_body * j.r));
  const Dual3 gained = to_body * (j.v - i.v - fall) - (constant(motion.velocity()) + corrected(6));
  const std::vector<Dual3> parts = {moved, angle, gained, j.gyro_bias - i.gyro_bias,
                                    j.accelerometer_bias - i.accelerometer_bias};
  StateVector value;
  Eigen::Matrix<double, kStateSize, test::kVariables> slope;
  for (int row = 0; row < kStateSize; ++row) {
    const Dual& part = parts[static_cast<std::size_t>(row / 3)][static_cast<std::size_t>(row % 3)];
    value[row] = part.v;
    slope.row(row) = part.d.transpose();
  }
  const StateMatrix whitening = sum.covariance().llt().matrixL().solve(StateMatrix::Identity());
  EXPECT_LT((residual - whitening * value).norm(), 1e-8 * residual.norm());
  Eigen::Matrix<double, kStateSize, test::kVariables> analytic;
  analytic << derivatives.from, derivatives.to, derivatives.globals;
  const Eigen::Matrix<double, kStateSize, test::kVariables> automatic = whitening * slope;
  EXPECT_LT((analytic - automatic).norm(), 1e-8 * automatic.norm());
}

INSTANTIATE_TEST_SUITE_P(Seeds, ImuTest, testing::Range(1, 11));

TEST(ImuPreintegrationTest, ConstantForceAndTurnAreExact) {
  // About z at 0.5 rad/s for 2 s, with a force that keeps a circle of radius 3
  // m.
  constexpr double kRate = 0.5;
  constexpr double kRadius = 3;
  constexpr int kSamples = 400;
  ImuMotion motion;
  const double dt = 2.0 / kSamples;
  for (int i = 0; i < kSamples; ++i) {
    motion.integrate({0, 0, kRate}, {0, kRate * kRate * kRadius, kGravity}, dt);
  }
  NavState start;
  start.velocity = Vector3d(kRate * kRadius, 0, 0);
  const NavState end = motion.propagate(start, kGravity);
  const double angle = 2 * kRate;
  EXPECT_LT((end.position - kRadius * Vector3d(std::sin(angle), 1 - std::cos(angle), 0)).norm(),
            1e-5);
  EXPECT_LT((end.R_map_body.inverse() * SO3::about_z(angle)).log().norm(), 1e-12);
  EXPECT_NEAR(motion.duration(), 2, 1e-12);
}

TEST(ImuPreintegrationTest, CovarianceOfABodyAtRestHasItsClosedForm) {
  // White noise integrated once and twice, and the biases' walks integrated up
  // to three times.
  const ImuNoise noise{.gyro = 1e-3,
                       .accelerometer = 2e-2,
                       .gyro_bias = 3e-4,
                       .accelerometer_bias = 4e-3,
                       .integration = 1e-9};
  constexpr int kSamples = 1000;
  constexpr double kTime = 1;
  ImuPreintegration sum;
  for (int i = 0; i < kSamples; ++i) {
    sum.integrate(Vector3d::Zero(), Vector3d::Zero(), kTime / kSamples, noise);
  }
  const StateMatrix& c = sum.covariance();
  const auto square = [](double x) { return x * x; };
  EXPECT_NEAR(c(kRotation, kRotation),
              square(noise.gyro) * kTime + square(noise.gyro_bias) * std::pow(kTime, 3) / 3, 1e-8);
  EXPECT_NEAR(c(kVelocity, kVelocity),
              square(noise.accelerometer) * kTime +
                  square(noise.accelerometer_bias) * std::pow(kTime, 3) / 3,
              1e-7);
  EXPECT_NEAR(c(kPosition, kPosition),
              square(noise.accelerometer) * std::pow(kTime, 3) / 3 +
                  square(noise.accelerometer_bias) * std::pow(kTime, 5) / 20,
              1e-7);
  EXPECT_NEAR(c(kPosition, kVelocity),
              square(noise.accelerometer) * square(kTime) / 2 +
                  square(noise.accelerometer_bias) * std::pow(kTime, 4) / 8,
              1e-7);
  EXPECT_NEAR(c(kVelocity, kAccelerometerBias),
              -square(noise.accelerometer_bias) * square(kTime) / 2, 1e-7);
  EXPECT_NEAR(c(kGyroBias, kGyroBias), square(noise.gyro_bias) * kTime, 1e-15);
}

TEST(ImuPreintegrationTest, ResidualsOfNoisySamplesAreOfCovarianceOne) {
  const ImuNoise noise{.gyro = 1e-3,
                       .accelerometer = 2e-2,
                       .gyro_bias = 3e-3,
                       .accelerometer_bias = 4e-2,
                       .integration = 1e-6};
  constexpr int kRuns = 2000;
  constexpr int kSamples = 40;
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3d(normal(engine), normal(engine), normal(engine)); };
  double sum = 0;
  StateVector mean = StateVector::Zero();
  for (int run = 0; run < kRuns; ++run) {
    NavState true_from;
    true_from.R_map_body = SO3::exp(vector());
    ImuMotion truth;
    ImuPreintegration measured;
    Vector3d gyro_bias = Vector3d::Zero();
    Vector3d force_bias = Vector3d::Zero();
    const double root = std::sqrt(kSampleTime);
    for (int i = 0; i < kSamples; ++i) {
      const Vector3d rate(std::sin(0.1 * i), 1, -0.5);
      const Vector3d force(1, std::cos(0.1 * i), kGravity);
      truth.integrate(rate, force, kSampleTime);
      measured.integrate(rate + gyro_bias + noise.gyro / root * vector(),
                         force + force_bias + noise.accelerometer / root * vector(), kSampleTime,
                         noise);
      gyro_bias += noise.gyro_bias * root * vector();
      force_bias += noise.accelerometer_bias * root * vector();
    }
    NavState true_to = truth.propagate(true_from, kGravity);
    true_to.gyro_bias = gyro_bias;
    true_to.accelerometer_bias = force_bias;
    const StateVector residual = ImuFactor(measured, kGravity).evaluate(true_from, true_to, {});
    sum += residual.squaredNorm();
    mean += residual / kRuns;
  }
  // Mean of 2000 chi-squares of 15 degrees: deviation sqrt(30 / 2000) = 0.12.
  EXPECT_NEAR(sum / kRuns, 15, 0.5);
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 4.0 / std::sqrt(kRuns));
}

TEST(ImuPreintegrationTest, OneSampleIsEnoughForAFactor) {
  ImuPreintegration sum;
  EXPECT_THROW(ImuFactor(sum, kGravity), std::invalid_argument);
  sum.integrate(Vector3d::Zero(), Vector3d(0, 0, kGravity), 1e-3, {});
  const ImuFactor factor(sum, kGravity);
  EXPECT_LT(factor.evaluate({}, {}, {}).norm(), 1e-9);
}

TEST(ImuPreintegrationTest, NoiseIsValidated) {
  EXPECT_NO_THROW(ImuNoise{}.validate());
  EXPECT_THROW(ImuNoise{.gyro = 0}.validate(), std::invalid_argument);
  EXPECT_THROW(ImuNoise{.integration = std::numeric_limits<double>::quiet_NaN()}.validate(),
               std::invalid_argument);
}

/// Rough ground shakes a vehicle at all frequencies: what it does between two readings, one of
/// which is missing, is not on a line between both.
TEST(ImuTimeline, WhereReadingsAreMissingTheMotionBetweenThemIsAsUncertainAsItIsShaken) {
  constexpr int kReadings = 500;
  constexpr int kFiner = 8;          // steps of the motion between two readings
  constexpr double kPeriod = 0.004;  // s
  constexpr double kShake = 0.1;     // m/s^2, of one such step
  constexpr double kLost = 0.3;
  constexpr int kTrials = 60;
  const ImuIntegration how{.noise = {.accelerometer = 1e-3}};
  double sum = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::mt19937_64 engine(static_cast<std::uint64_t>(trial) + 1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    ImuTimeline timeline(kReadings);
    double force = 0;
    double gained = 0;  // m/s
    double kept_time = 0;
    double kept_force = 0;
    for (int i = 1; i < kReadings; ++i) {
      for (int step = 0; step < kFiner; ++step) {
        const double before = force;
        force += kShake * normal(engine);
        gained += 0.5 * (before + force) * kPeriod / kFiner;
      }
      const bool lost = uniform(engine) < kLost;
      if (lost && i > kReadings / 4 && i + 1 < kReadings) {
        continue;
      }
      const double time = i * kPeriod;
      timeline.push({kept_time, time - kept_time, Vector3d::Zero(),
                     Vector3d(0, 0, 0.5 * (kept_force + force))});
      kept_time = time;
      kept_force = force;
    }
    ImuPreintegration integrated{Vector3d::Zero(), Vector3d::Zero()};
    timeline.integrate(how, geometry::SO3(), 0, kept_time, integrated);
    const double error = integrated.motion().velocity().z() - gained;
    sum += error * error / integrated.covariance()(kVelocity + 2, kVelocity + 2);
  }
  EXPECT_GT(sum / kTrials, 0.3);
  EXPECT_LT(sum / kTrials, 1.5);  // of one degree
}

}  // namespace
}  // namespace pipescout::estimation
