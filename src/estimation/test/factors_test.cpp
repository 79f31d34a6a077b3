// SPDX-License-Identifier: Apache-2.0
// Every factor against its formula, written again over numbers that carry their derivatives.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "dual.hpp"
#include "pipescout/estimation/factors.hpp"
#include "pipescout/estimation/pipe_centre_line.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;
using test::constant;
using test::Dual;
using test::Dual3;
using test::DualGlobals;
using test::DualState;

class FactorsTest : public testing::TestWithParam<int> {
 protected:
  double draw(double scale) { return std::normal_distribution<double>(0, scale)(engine_); }
  Vector3d vector(double scale) { return {draw(scale), draw(scale), draw(scale)}; }
  SO3 rotation(double scale) { return SO3::exp(vector(scale)); }
  template <int N>
  Eigen::Matrix<double, N, N> covariance() {
    const Eigen::Matrix<double, N, N> a =
        Eigen::Matrix<double, N, N>::NullaryExpr([&] { return draw(1); });
    return a * a.transpose() + 0.1 * Eigen::Matrix<double, N, N>::Identity();
  }
  NavState state() {
    return {.R_map_body = rotation(1),
            .position = vector(10),
            .velocity = vector(2),
            .gyro_bias = vector(0.1),
            .accelerometer_bias = vector(0.1)};
  }
  GlobalStates globals() {
    return {
        .odometer_scale = 1 + draw(0.1),
        .mount_yaw = draw(0.3),
        .mount_pitch = draw(0.3),
        .rack_position = vector(5),
        .R_map_rack = rotation(1),
        .gps_lever_arm = vector(1),
        .gps_time_offset = draw(0.2),
        .visual_pose_time_offset = draw(0.2),
        .imu_scale = ImuScale{}.retract(ImuScaleVector::NullaryExpr([&] { return draw(0.1); }))};
  }

  /// `plain` is the residual before it is whitened with the inverse root of `covariance`.
  template <int N>
  void compare(const Eigen::Matrix<double, N, 1>& residual, const Jacobians<N>& derivatives,
               const std::vector<Dual>& plain, const Eigen::Matrix<double, N, N>& covariance) {
    const Eigen::Matrix<double, N, N> whitening =
        covariance.llt().matrixL().solve(Eigen::Matrix<double, N, N>::Identity());
    Eigen::Matrix<double, N, 1> value;
    Eigen::Matrix<double, N, test::kVariables> slope;
    for (int i = 0; i < N; ++i) {
      value[i] = plain[static_cast<std::size_t>(i)].v;
      slope.row(i) = plain[static_cast<std::size_t>(i)].d.transpose();
    }
    value = (whitening * value).eval();
    slope = (whitening * slope).eval();
    constexpr double kRounding = 1e-8;
    EXPECT_LT((residual - value).norm(), kRounding * (1 + value.norm()));
    Eigen::Matrix<double, N, test::kVariables> analytic;
    analytic << derivatives.from, derivatives.to, derivatives.globals;
    EXPECT_LT((analytic - slope).cwiseAbs().maxCoeff(), kRounding * (1 + slope.norm()))
        << "analytic\n"
        << analytic << "\nautomatic\n"
        << slope;
  }

  template <class Factor>
  void check_absolute(const typename Factor::MeasurementType& m, const NavState& x,
                      const GlobalStates& g, const std::vector<Dual>& plain,
                      const Eigen::Matrix<double, Factor::kRows, Factor::kRows>& covariance) {
    ASSERT_EQ(check(m), InputFault::kNone);
    const Factor factor(m);
    typename Factor::Derivatives derivatives;
    const auto residual = factor.evaluate(x, g, &derivatives);
    EXPECT_EQ(residual, factor.evaluate(x, g));
    compare<Factor::kRows>(residual, derivatives, plain, covariance);
  }

  template <class Factor>
  void check_relative(const typename Factor::MeasurementType& m, const NavState& from,
                      const NavState& to, const GlobalStates& g, const std::vector<Dual>& plain,
                      const Eigen::Matrix<double, Factor::kRows, Factor::kRows>& covariance) {
    ASSERT_EQ(check(m), InputFault::kNone);
    const Factor factor(m);
    typename Factor::Derivatives derivatives;
    const auto residual = factor.evaluate(from, to, g, &derivatives);
    EXPECT_EQ(residual, factor.evaluate(from, to, g));
    compare<Factor::kRows>(residual, derivatives, plain, covariance);
  }

  static std::vector<Dual> list(std::initializer_list<Dual3> parts) {
    std::vector<Dual> all;
    for (const Dual3& part : parts) {
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  }

  std::mt19937_64 engine_{static_cast<std::uint64_t>(GetParam())};
};

TEST_P(FactorsTest, Gps) {
  const GpsMeasurement m{.time = 1,
                         .position = vector(10),
                         .covariance = covariance<3>(),
                         .angular_rate = vector(0.5)};
  const NavState x = state();
  const GlobalStates g = globals();
  const DualState dx(x, test::kFromPlace);
  const DualGlobals dg(g);
  const Dual3 swing = test::cross_matrix(constant(m.angular_rate)) * dg.lever;
  check_absolute<GpsFactor>(
      m, x, g,
      list({dx.p + dg.time_offset * dx.v + dx.r * (dg.lever + dg.time_offset * swing) -
            constant(m.position)}),
      m.covariance);
}

TEST_P(FactorsTest, Heading) {
  const HeadingMeasurement m{.time = 1, .heading = draw(1), .standard_deviation = 0.1};
  const NavState x = state();
  const DualState dx(x, test::kFromPlace);
  Dual plain = atan2(dx.r[1][0], dx.r[0][0]) - m.heading;
  plain.v = std::remainder(plain.v, 2 * std::acos(-1.0));
  check_absolute<HeadingFactor>(m, x, {}, {plain}, Eigen::Matrix<double, 1, 1>(0.01));
}

TEST_P(FactorsTest, VisualPose) {
  const VisualPoseMeasurement m{.time = 1,
                                .T_rack_body = SE3(rotation(1), vector(10)),
                                .covariance = covariance<6>(),
                                .angular_rate = vector(1)};
  const NavState x = state();
  const GlobalStates g = globals();
  const DualState dx(x, test::kFromPlace);
  const DualGlobals dg(g);
  const auto to_rack = transpose(dg.rack_rotation);
  const auto measured = constant(m.T_rack_body.rotation().inverse().matrix());
  const auto turned = test::rotation(dg.visual_time_offset * constant(m.angular_rate));
  check_absolute<VisualPoseFactor>(
      m, x, g,
      list({to_rack * (dx.p + dg.visual_time_offset * dx.v - dg.rack_position) -
                constant(m.T_rack_body.translation()),
            log(measured * (to_rack * (dx.r * turned)))}),
      m.covariance);
}

TEST_P(FactorsTest, Weld) {
  WeldMeasurement m{.time = 1,
                    .position = vector(10),
                    .direction = vector(1).normalized(),
                    .along_deviation = 0.3,
                    .across_deviation = 0.02,
                    .sensor = vector(1)};
  const NavState x = state();
  const DualState dx(x, test::kFromPlace);
  const WeldFactor factor(m);
  Jacobians<3> derivatives;
  const auto residual = factor.evaluate(x, {}, &derivatives);
  // Its whitening is the symmetric root; the lower triangular one of `compare` is a turn away.
  const Eigen::Matrix3d along = m.direction * m.direction.transpose();
  const Eigen::Matrix3d covariance = 0.09 * along + 0.0004 * (Eigen::Matrix3d::Identity() - along);
  const Eigen::Matrix3d lower = covariance.llt().matrixL().solve(Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d root = along / 0.3 + (Eigen::Matrix3d::Identity() - along) / 0.02;
  const Eigen::Matrix3d turn = lower * root.inverse();
  EXPECT_LT((turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  derivatives.from = (turn * derivatives.from).eval();
  compare<3>(turn * residual, derivatives,
             list({dx.p + dx.r * constant(m.sensor) - constant(m.position)}), covariance);
}

TEST_P(FactorsTest, CentreLine) {
  const CentreLineMeasurement m{.time = 1,
                                .position = vector(10),
                                .direction = vector(1).normalized(),
                                .standard_deviation = 0.02};
  const NavState x = state();
  const DualState dx(x, test::kFromPlace);
  Eigen::Matrix<double, 2, 3> across;
  across.row(0) = m.direction.unitOrthogonal().transpose();
  across.row(1) = m.direction.cross(Vector3d(across.row(0))).transpose();
  const auto off = dx.p - constant(m.position);
  const auto along = [&](Eigen::Index row) {
    return across(row, 0) * off[0] + across(row, 1) * off[1] + across(row, 2) * off[2];
  };
  check_absolute<CentreLineFactor>(m, x, {}, {along(0), along(1)},
                                   Eigen::Matrix2d(0.0004 * Eigen::Matrix2d::Identity()));
  // How far along the line it is does not matter.
  NavState farther = x;
  farther.position += 3 * m.direction;
  EXPECT_LT(
      (CentreLineFactor(m).evaluate(farther, {}) - CentreLineFactor(m).evaluate(x, {})).norm(),
      1e-9);
}

TEST_P(FactorsTest, NonHolonomic) {
  const NonHolonomicMeasurement m{.time = 1,
                                  .lateral_deviation = 0.1,
                                  .vertical_deviation = 0.2,
                                  .sensor = vector(1),
                                  .angular_rate = vector(0.5)};
  const NavState x = state();
  const GlobalStates g = globals();
  const DualState dx(x, test::kFromPlace);
  const DualGlobals dg(g);
  const Dual3 rate = dg.gyro_scale * (constant(m.angular_rate) - dx.gyro_bias);
  const Dual3 swing = test::cross_matrix(rate) * constant(m.sensor);
  const Dual3 seen = dg.travel() * (transpose(dx.r) * dx.v + swing);
  check_absolute<NonHolonomicFactor>(m, x, g, {seen[1], seen[2]},
                                     Eigen::Vector2d(0.01, 0.04).asDiagonal());
}

TEST_P(FactorsTest, ZeroVelocity) {
  const ZeroVelocityMeasurement m{.time = 1, .standard_deviation = 0.1};
  const NavState x = state();
  check_absolute<ZeroVelocityFactor>(m, x, {}, list({DualState(x, test::kFromPlace).v}),
                                     0.01 * Eigen::Matrix3d::Identity());
}

TEST_P(FactorsTest, ZeroAngularRate) {
  const ZeroAngularRateMeasurement m{
      .time = 1, .angular_rate = vector(0.1), .standard_deviation = 0.01};
  const NavState x = state();
  check_absolute<ZeroAngularRateFactor>(
      m, x, {}, list({constant(m.angular_rate) - DualState(x, test::kFromPlace).gyro_bias}),
      1e-4 * Eigen::Matrix3d::Identity());
}

TEST_P(FactorsTest, Odometer) {
  const OdometerMeasurement m{.from_time = 1,
                              .to_time = 2,
                              .distance = draw(1),
                              .standard_deviation = 0.1,
                              .across_deviation = 0.2,
                              .sensor = vector(1)};
  const NavState from = state();
  NavState to = from.retract(StateVector::NullaryExpr([&] { return draw(0.5); }));
  const GlobalStates g = globals();
  const DualState di(from, test::kFromPlace);
  const DualState dj(to, test::kToPlace);
  const DualGlobals dg(g);
  const Dual a = test::angle_of(transpose(di.r) * dj.r);
  const Dual3 sensor = constant(m.sensor);
  const Dual3 moved = dj.p + dj.r * sensor - di.p - di.r * sensor;
  Dual3 plain = dg.travel() * (Dual(0.5) * ((transpose(di.r) + transpose(dj.r)) * moved));
  plain[0] = plain[0] / dg.scale - m.distance * sin(a) / a;
  check_relative<OdometerFactor>(m, from, to, g, list({plain}),
                                 Vector3d(0.01, 0.04, 0.04).asDiagonal());
}

TEST_P(FactorsTest, RelativePose) {
  const RelativePoseMeasurement m{.from_time = 1,
                                  .to_time = 2,
                                  .T_from_to = SE3(rotation(0.5), vector(1)),
                                  .covariance = covariance<6>()};
  const NavState from = state();
  const NavState to = state();
  const DualState di(from, test::kFromPlace);
  const DualState dj(to, test::kToPlace);
  const auto measured = constant(m.T_from_to.rotation().inverse().matrix());
  const auto to_from = transpose(di.r);
  check_relative<RelativePoseFactor>(
      m, from, to, {},
      list({measured * (to_from * (dj.p - di.p) - constant(m.T_from_to.translation())),
            log(measured * (to_from * dj.r))}),
      m.covariance);
}

TEST_P(FactorsTest, Prior) {
  const NavState mean = state();
  const NavState x = state();
  const StateMatrix c = covariance<kStateSize>();
  const PriorFactor factor(mean, c);
  Jacobians<kStateSize> derivatives;
  const StateVector residual = factor.evaluate(x, &derivatives);
  const DualState dx(x, test::kFromPlace);
  compare<kStateSize>(residual, derivatives,
                      list({dx.p - constant(mean.position),
                            log(constant(mean.R_map_body.inverse().matrix()) * dx.r),
                            dx.v - constant(mean.velocity), dx.gyro_bias - constant(mean.gyro_bias),
                            dx.accelerometer_bias - constant(mean.accelerometer_bias)}),
                      c);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FactorsTest, testing::Range(1, 21));

TEST(OdometerFactorTest, AnArcOfACircleHasNoResidual) {
  // Radius 2 m, by 0.8 rad, about an axis across the travel; the odometer reads 4 % too little.
  constexpr double kRadius = 2;
  constexpr double kTurn = 0.8;
  NavState from;
  NavState to;
  to.R_map_body = SO3::about_z(kTurn);
  to.position = kRadius * Vector3d(std::sin(kTurn), 1 - std::cos(kTurn), 0);
  const GlobalStates globals{.odometer_scale = 1 / 0.96};
  const OdometerFactor factor({.from_time = 0,
                               .to_time = 1,
                               .distance = 0.96 * kRadius * kTurn,
                               .standard_deviation = 1e-3,
                               .across_deviation = 1e-3});
  EXPECT_LT(factor.evaluate(from, to, globals).norm(), 1e-9);
  // A body that stands still and one that turns on the spot have none either.
  const OdometerFactor still({.from_time = 0,
                              .to_time = 1,
                              .distance = 0,
                              .standard_deviation = 1e-3,
                              .across_deviation = 1e-3});
  to.position.setZero();
  EXPECT_LT(still.evaluate(from, to, globals).norm(), 1e-12);
}

TEST(HeadingFactorTest, IsUndefinedOnAVerticalAxisAlone) {
  const HeadingFactor factor({.time = 0, .heading = 3.1, .standard_deviation = 0.1});
  NavState x;
  x.R_map_body = SO3::about_y(-0.5 * std::acos(-1.0));
  Jacobians<1> derivatives;
  EXPECT_TRUE(std::isnan(factor.evaluate(x, {}, &derivatives)[0]));
  EXPECT_FALSE(derivatives.from.allFinite());
  // Across the cut at pi: -3.1 is 0.083 rad from 3.1.
  x.R_map_body = SO3::about_z(-3.1);
  EXPECT_NEAR(factor.evaluate(x, {})[0], (2 * std::acos(-1.0) - 6.2) / 0.1, 1e-9);
}

TEST(MeasurementsTest, BadNumbersAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  GpsMeasurement gps{.time = 0, .covariance = Eigen::Matrix3d::Identity()};
  EXPECT_EQ(check(gps), InputFault::kNone);
  gps.covariance(0, 1) = 0.5;  // not symmetric
  EXPECT_EQ(check(gps), InputFault::kBadCovariance);
  gps.covariance(1, 0) = 0.5;
  EXPECT_EQ(check(gps), InputFault::kNone);
  gps.covariance(0, 1) = gps.covariance(1, 0) = 1;  // of rank 2
  EXPECT_EQ(check(gps), InputFault::kBadCovariance);
  gps.covariance.setZero();
  EXPECT_EQ(check(gps), InputFault::kBadCovariance);
  gps.covariance = -Eigen::Matrix3d::Identity();
  EXPECT_EQ(check(gps), InputFault::kBadCovariance);
  gps.covariance(2, 2) = nan;
  EXPECT_EQ(check(gps), InputFault::kNotFinite);
  EXPECT_EQ(check(HeadingMeasurement{.time = nan, .heading = 0, .standard_deviation = 1}),
            InputFault::kNotFinite);
  EXPECT_EQ(check(HeadingMeasurement{.time = 0, .heading = 0, .standard_deviation = 0}),
            InputFault::kBadCovariance);
  EXPECT_EQ(check(ZeroVelocityMeasurement{.time = 0, .standard_deviation = -1}),
            InputFault::kBadCovariance);
  EXPECT_EQ(check(ZeroAngularRateMeasurement{.time = 0, .standard_deviation = 0}),
            InputFault::kBadCovariance);
  EXPECT_EQ(check(ZeroAngularRateMeasurement{
                .time = 0, .angular_rate = Vector3d(nan, 0, 0), .standard_deviation = 1}),
            InputFault::kNotFinite);
  EXPECT_EQ(check(NonHolonomicMeasurement{.time = 0, .lateral_deviation = 1}),
            InputFault::kBadCovariance);
  EXPECT_EQ(check(OdometerMeasurement{.from_time = 1,
                                      .to_time = 1,
                                      .distance = 0,
                                      .standard_deviation = 1,
                                      .across_deviation = 1}),
            InputFault::kBadInterval);
  EXPECT_EQ(
      check(WeldMeasurement{
          .time = 0, .direction = Vector3d(2, 0, 0), .along_deviation = 1, .across_deviation = 1}),
      InputFault::kBadDirection);
  EXPECT_EQ(check(CentreLineMeasurement{.direction = Vector3d(0, 0, 2), .standard_deviation = 1}),
            InputFault::kBadDirection);
  EXPECT_EQ(check(CentreLineMeasurement{}), InputFault::kBadCovariance);
  EXPECT_EQ(check(RelativePoseMeasurement{.from_time = 0, .to_time = 1}),
            InputFault::kBadCovariance);
  EXPECT_EQ(check(VisualPoseMeasurement{.time = 0, .covariance = geometry::Matrix6d::Identity()}),
            InputFault::kNone);
}

TEST(PriorFactorTest, RefusesWhatIsNoCovariance) {
  EXPECT_THROW(PriorFactor({}, StateMatrix::Zero()), std::invalid_argument);
  NavState mean;
  mean.position.x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(PriorFactor(mean, StateMatrix::Identity()), std::invalid_argument);
}

TEST(PipeCentreLineTest, WeldsLieAtTheirChainage) {
  const PipeCentreLine line({{0, 0, 0}, {3, 0, 0}, {3, 4, 0}}, 100);
  EXPECT_EQ(line.last_chainage(), 107);
  EXPECT_TRUE(line.at(101.5)->position.isApprox(Vector3d(1.5, 0, 0)));
  EXPECT_TRUE(line.at(105)->position.isApprox(Vector3d(3, 2, 0)));
  EXPECT_EQ(line.at(103)->direction, Vector3d::UnitY());
  EXPECT_TRUE(line.at(107)->position.isApprox(Vector3d(3, 4, 0)));
  EXPECT_FALSE(line.at(99.9));
  EXPECT_FALSE(line.at(107.1));
  EXPECT_FALSE(line.at(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_NEAR(line.chainage_of({1.2, 0.3, 0.1}, 100), 101.2, 1e-12);
  EXPECT_NEAR(line.chainage_of({3.2, 3, 0}, 101), 106, 1e-12);
  EXPECT_EQ(line.chainage_of({3, 9, 0}, 106), 107);
  EXPECT_TRUE(std::isnan(line.chainage_of(Vector3d::Constant(std::nan("")), 100)));
  const auto weld = line.weld(5, 105, 0.1, 0.02, Vector3d(0.3, 0, 0));
  ASSERT_TRUE(weld);
  EXPECT_EQ(check(*weld), InputFault::kNone);
  EXPECT_THROW(PipeCentreLine({{0, 0, 0}}), std::invalid_argument);
  EXPECT_THROW(PipeCentreLine({{0, 0, 0}, {0, 0, 0}}), std::invalid_argument);
  EXPECT_THROW(PipeCentreLine({{0, 0, 0}, {0, 0, std::nan("")}}), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::estimation
