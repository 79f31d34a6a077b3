// SPDX-License-Identifier: Apache-2.0
// What no update may fall over.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "simulated_flight.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::SO3;
using test::SimulatedFlight;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::size_t counted(const FixedLagSmoother& smoother, FactorKind kind, Outcome outcome) {
  return smoother.counts(kind)[static_cast<std::size_t>(outcome)];
}

class SmootherFaultsTest : public testing::Test {
 protected:
  static constexpr int kKeyframes = 60;

  FixedLagSmoother flown(int keyframes,
                         FixedLagSmootherParameters parameters = test::flight_parameters()) {
    FixedLagSmoother smoother(parameters);
    smoother.initialise(0, flight_.first, flight_.first_covariance);
    for (int k = 0; k < keyframes; ++k) {
      flight_.feed(smoother, k, true, true, true);
    }
    return smoother;
  }
  static NavState newest(const FixedLagSmoother& smoother) {
    return smoother.state(smoother.keyframes() - 1);
  }
  double error(const FixedLagSmoother& smoother, int keyframe) const {
    return (newest(smoother).position - flight_.truth[static_cast<std::size_t>(keyframe)].position)
        .norm();
  }
  static GpsMeasurement gps(double time, const Vector3d& position, double deviation = 0.2) {
    return {time, position, deviation * deviation * Matrix3d::Identity()};
  }

  SimulatedFlight flight_{11, kKeyframes};
};

TEST_F(SmootherFaultsTest, NothingBeforeTheFirstState) {
  FixedLagSmoother smoother({});
  EXPECT_EQ(smoother.add(gps(0, Vector3d::Zero())), Outcome::kUninitialised);
  EXPECT_EQ(smoother.add(flight_.imu[0]), Outcome::kUninitialised);
  EXPECT_FALSE(smoother.update(1).initialised);
  EXPECT_EQ(smoother.keyframes(), 0U);
}

TEST_F(SmootherFaultsTest, BadNumbersAreCountedByName) {
  FixedLagSmoother smoother = flown(20);
  const NavState before = newest(smoother);
  EXPECT_EQ(smoother.add(gps(kNan, Vector3d::Zero())), Outcome::kNotFinite);
  EXPECT_EQ(smoother.add(gps(1.9, Vector3d::Zero(), 0)), Outcome::kBadCovariance);
  EXPECT_EQ(smoother.add(HeadingMeasurement{1.9, 0, -1}), Outcome::kBadCovariance);
  EXPECT_EQ(smoother.add(OdometerMeasurement{1.9, 1.8, 1, 1, 1}), Outcome::kBadInterval);
  EXPECT_EQ(smoother.add(ImuSample{2, 0.01, Vector3d(kNan, 0, 0), Vector3d::Zero()}),
            Outcome::kNotFinite);
  EXPECT_EQ(smoother.add(ImuSample{2, 0.01, Vector3d(1e300, 0, 0), Vector3d::Zero()}),
            Outcome::kNotFinite);
  EXPECT_EQ(smoother.add(ImuSample{2, 0, Vector3d::Zero(), Vector3d::Zero()}),
            Outcome::kBadInterval);
  EXPECT_EQ(counted(smoother, FactorKind::kGps, Outcome::kNotFinite), 1U);
  EXPECT_EQ(counted(smoother, FactorKind::kGps, Outcome::kBadCovariance), 1U);
  EXPECT_EQ(counted(smoother, FactorKind::kHeading, Outcome::kBadCovariance), 1U);
  EXPECT_EQ(counted(smoother, FactorKind::kImu, Outcome::kNotFinite), 2U);
  EXPECT_EQ(to_string(FactorKind::kGps), "gps");
  EXPECT_EQ(to_string(Outcome::kBadCovariance), "bad_covariance");
  EXPECT_TRUE(smoother.update(kNan).time_refused);
  EXPECT_FALSE(smoother.update(1.9).new_keyframe);
  EXPECT_LT(before.local(newest(smoother)).norm(), 1e-9);
}

TEST_F(SmootherFaultsTest, LateMeasurementsEnterWithinTheLagAsIfInTime) {
  FixedLagSmoother in_time(test::flight_parameters());
  FixedLagSmoother late(test::flight_parameters());
  in_time.initialise(0, flight_.first, flight_.first_covariance);
  late.initialise(0, flight_.first, flight_.first_covariance);
  for (int k = 0; k < 40; ++k) {
    flight_.feed(in_time, k, true, false, true);
    if (k >= 7) {
      late.add(flight_.gps[static_cast<std::size_t>(k - 7)]);
    }
    flight_.feed(late, k, false, false, true);
  }
  for (std::size_t k = 33; k < 40; ++k) {
    EXPECT_EQ(late.add(flight_.gps[k]), Outcome::kWaiting);
  }
  // Older than the lag:
  EXPECT_EQ(late.add(gps(1, Vector3d::Zero())), Outcome::kLate);
  EXPECT_EQ(counted(late, FactorKind::kGps, Outcome::kLate), 1U);
  const UpdateReport& report = late.update(3.9);
  EXPECT_FALSE(report.new_keyframe);
  EXPECT_EQ(report.factors.size(), 7U);
  const StateVector apart = newest(in_time).local(newest(late));
  const StateVector deviations = in_time.covariance(in_time.keyframes() - 1).diagonal().cwiseSqrt();
  EXPECT_LT(apart.cwiseQuotient(deviations).cwiseAbs().maxCoeff(), 0.05);
}

TEST_F(SmootherFaultsTest, ATimeBetweenKeyframesIsCarriedThere) {
  FixedLagSmoother smoother = flown(30);
  // Half way between two keyframes, as the propagation sees it.
  for (std::size_t i = 290; i < 295; ++i) {
    smoother.add(flight_.imu[i]);
  }
  const NavState half_way = smoother.propagated()->state;
  for (std::size_t i = 295; i < 300; ++i) {
    smoother.add(flight_.imu[i]);
  }
  smoother.add(gps(2.95, half_way.position, 1e-3));
  const UpdateReport& report = smoother.update(3.0);
  ASSERT_EQ(report.factors.size(), 1U);
  EXPECT_LT(report.factors[0].chi_square, 1e-3);
  // An odometer over an interval that begins and ends between keyframes.
  for (std::size_t i = 300; i < 310; ++i) {
    smoother.add(flight_.imu[i]);
  }
  const auto& from = flight_.truth[29];
  const auto& to = flight_.truth[30];
  EXPECT_EQ(
      smoother.add(OdometerMeasurement{2.96, 3.06, (to.position - from.position).norm(), 0.05, 5}),
      Outcome::kWaiting);
  EXPECT_EQ(smoother.add(OdometerMeasurement{2.5, 3.06, 0.1, 0.05, 5}), Outcome::kWaiting);
  const UpdateReport& next = smoother.update(3.1);
  ASSERT_EQ(next.factors.size(), 2U);
  EXPECT_EQ(next.factors[0].outcome, Outcome::kBadInterval);  // over more than two keyframes
  EXPECT_EQ(next.factors[1].outcome, Outcome::kAccepted);
}

TEST_F(SmootherFaultsTest, DuplicatesAreRefused) {
  FixedLagSmoother smoother = flown(20);
  EXPECT_EQ(smoother.add(flight_.gps[19]), Outcome::kDuplicate);
  EXPECT_EQ(smoother.add(flight_.vision[10]), Outcome::kDuplicate);
  EXPECT_EQ(smoother.add(flight_.odometry[19]), Outcome::kDuplicate);
  EXPECT_EQ(smoother.add(flight_.imu[189]), Outcome::kDuplicate);
  EXPECT_EQ(smoother.add(flight_.imu[188]), Outcome::kLate);
  EXPECT_EQ(smoother.add(gps(1.9, Vector3d::Zero())), Outcome::kWaiting);
  EXPECT_EQ(smoother.add(gps(1.9, Vector3d::Zero())), Outcome::kDuplicate);
  EXPECT_EQ(counted(smoother, FactorKind::kGps, Outcome::kDuplicate), 2U);
}

TEST_F(SmootherFaultsTest, QueuesAreBounded) {
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.max_waiting = 4;
  parameters.max_factors_per_keyframe = 3;
  FixedLagSmoother smoother = flown(20, parameters);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(smoother.add(gps(2.0, Vector3d(i, 0, 0), 100)), Outcome::kWaiting);
  }
  EXPECT_EQ(smoother.add(gps(2.0, Vector3d(4, 0, 0), 100)), Outcome::kFull);
  const UpdateReport& report = smoother.update(2.0);
  EXPECT_EQ(std::count_if(report.factors.begin(), report.factors.end(),
                          [](const FactorReport& f) { return f.outcome == Outcome::kFull; }),
            1);
  EXPECT_EQ(counted(smoother, FactorKind::kGps, Outcome::kFull), 2U);
  EXPECT_EQ(smoother.add(gps(5, Vector3d::Zero())), Outcome::kFuture);
}

TEST_F(SmootherFaultsTest, JumpsOfTimeResetWithTheirReason) {
  FixedLagSmoother forwards = flown(30);
  EXPECT_EQ(forwards.update(10).reset, ResetReason::kTimeJumpForwards);
  EXPECT_FALSE(forwards.initialised());
  EXPECT_FALSE(forwards.update(10.1).initialised);
  EXPECT_FALSE(forwards.propagated());
  FixedLagSmoother backwards = flown(30);
  EXPECT_EQ(backwards.update(0.1).reset, ResetReason::kTimeJumpBackwards);
  EXPECT_EQ(to_string(ResetReason::kTimeJumpBackwards), "time_jump_backwards");
  // It starts again.
  backwards.initialise(0, flight_.first, flight_.first_covariance);
  for (int k = 0; k < 30; ++k) {
    EXPECT_EQ(flight_.feed(backwards, k, true, true, true).reset, ResetReason::kNone);
  }
  EXPECT_LT(error(backwards, 29), 0.15);
}

TEST_F(SmootherFaultsTest, TheGateKeepsOutliersOut) {
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.robustness = FixedLagSmootherParameters::default_robustness();
  FixedLagSmoother smoother = flown(30, parameters);
  const NavState before = newest(smoother);
  const Vector3d true_place = flight_.truth[29].position;
  smoother.add(gps(2.9, true_place + Vector3d(5, 0, 0)));
  smoother.add(gps(2.0, true_place + Vector3d(5, 0, 0)));  // late as well
  const UpdateReport& report = smoother.update(2.9);
  ASSERT_EQ(report.factors.size(), 2U);
  for (const FactorReport& factor : report.factors) {
    EXPECT_EQ(factor.outcome, Outcome::kGated);
    EXPECT_GT(factor.chi_square, 21.1);  // the quantile of 0.9999 of three degrees
    EXPECT_EQ(factor.weight, 0);
  }
  EXPECT_LT(before.local(newest(smoother)).norm(), 1e-9);
  EXPECT_LT(smoother.counts(FactorKind::kGps)[static_cast<std::size_t>(Outcome::kGated)], 4U);
}

TEST_F(SmootherFaultsTest, KernelsTakeWeightFromOutliers) {
  for (const statistics::RobustKernel kernel :
       {statistics::RobustKernel::kHuber, statistics::RobustKernel::kCauchy,
        statistics::RobustKernel::kSaliency}) {
    FixedLagSmootherParameters parameters = test::flight_parameters();
    FixedLagSmoother plain = flown(30, parameters);
    parameters.robustness[static_cast<std::size_t>(FactorKind::kGps)].kernel = kernel;
    FixedLagSmoother robust = flown(30, parameters);
    const NavState plain_before = newest(plain);
    const NavState robust_before = newest(robust);
    const GpsMeasurement outlier = gps(2.9, flight_.truth[29].position + Vector3d(5, 0, 0));
    plain.add(outlier);
    robust.add(outlier);
    plain.update(2.9);
    const UpdateReport& report = robust.update(2.9);
    ASSERT_EQ(report.factors.size(), 1U);
    EXPECT_LT(report.factors[0].weight, 0.1);
    EXPECT_LT(robust_before.local(newest(robust)).segment<3>(kPosition).norm(),
              0.15 * plain_before.local(newest(plain)).segment<3>(kPosition).norm())
        << to_string(kernel);
  }
}

TEST_F(SmootherFaultsTest, AnUndefinedHeadingIsQuarantined) {
  FixedLagSmoother smoother({});
  NavState up;
  up.R_map_body = SO3::about_y(-0.5 * std::numbers::pi);
  smoother.initialise(0, up, 1e-4 * StateMatrix::Identity());
  smoother.add(HeadingMeasurement{0, 1, 0.1});
  const UpdateReport& report = smoother.update(0);
  ASSERT_EQ(report.factors.size(), 1U);
  EXPECT_EQ(report.factors[0].kind, FactorKind::kHeading);
  EXPECT_EQ(report.factors[0].outcome, Outcome::kQuarantined);
  EXPECT_EQ(report.reset, ResetReason::kNone);
  EXPECT_TRUE(newest(smoother).is_finite());
}

TEST_F(SmootherFaultsTest, AFactorThatDrownsAllOthersIsQuarantined) {
  // A lever arm of 1000 km and a fix of a nanometre: next to its information about position and
  // attitude together, what is known about either is rounding.
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.globals.gps_lever_arm = Vector3d(1e6, 0, 0);
  FixedLagSmoother smoother(parameters);
  smoother.initialise(0, flight_.first, flight_.first_covariance);
  for (int k = 0; k < 20; ++k) {
    flight_.feed(smoother, k, false, true, true);
  }
  const NavState before = newest(smoother);
  smoother.add(
      gps(1.9, before.position + before.R_map_body * parameters.globals.gps_lever_arm, 1e-9));
  const UpdateReport& report = smoother.update(1.9);
  EXPECT_EQ(report.reset, ResetReason::kNone);
  ASSERT_EQ(report.factors.size(), 1U);
  EXPECT_EQ(report.factors[0].kind, FactorKind::kGps);
  EXPECT_EQ(report.factors[0].outcome, Outcome::kQuarantined);
  EXPECT_EQ(counted(smoother, FactorKind::kGps, Outcome::kQuarantined), 1U);
  for (int k = 20; k < 30; ++k) {
    EXPECT_EQ(flight_.feed(smoother, k, false, true, true).reset, ResetReason::kNone);
  }
  EXPECT_LT(error(smoother, 29), 0.15);
}

TEST_F(SmootherFaultsTest, OfThoseThatComeTogetherTheOneThatTheOthersContradictIsGated) {
  // What is known beforehand admits all of them, one by one.
  constexpr int kLate = 8;
  for (const int wrong : {0, 3, kLate}) {
    FixedLagSmootherParameters parameters = test::flight_parameters();
    parameters.robustness[static_cast<std::size_t>(FactorKind::kGps)].gate_probability = 0.9999;
    FixedLagSmoother smoother(parameters);
    StateVector known = StateVector::Constant(0.01);
    known.segment<3>(kPosition).setConstant(20);
    known.segment<3>(kVelocity).setConstant(5);
    smoother.initialise(0, flight_.truth[0], known.cwiseAbs2().asDiagonal());
    for (int k = 0; k <= kLate; ++k) {
      flight_.feed(smoother, k, false, false, false);
    }
    for (int k = 0; k <= kLate; ++k) {
      GpsMeasurement fix = flight_.gps[static_cast<std::size_t>(k)];
      fix.position.y() += k == wrong ? 15 : 0;
      smoother.add(fix);
    }
    const UpdateReport& report = smoother.update(SimulatedFlight::time_of(kLate));
    ASSERT_EQ(report.factors.size(), kLate + 1U);
    for (const FactorReport& factor : report.factors) {
      const bool off = std::abs(factor.time - SimulatedFlight::time_of(wrong)) < 0.01;
      EXPECT_EQ(factor.outcome, off ? Outcome::kGated : Outcome::kAccepted) << factor.time;
    }
    EXPECT_LT(error(smoother, kLate), 0.6);
  }
}

TEST_F(SmootherFaultsTest, WhatLeadsOutOfTheWorldIsQuarantined) {
  // No gates here. Both are finite, and their covariances are sound.
  FixedLagSmoother smoother = flown(20);
  smoother.add(gps(1.9, Vector3d(1e9, 0, 0)));
  RelativePoseMeasurement leap = flight_.odometry[20];
  leap.T_from_to = geometry::SE3(SO3(), Vector3d(0, 1e9, 0));
  smoother.add(leap);
  for (int k = 20; k < 30; ++k) {
    const UpdateReport& report = flight_.feed(smoother, k, true, true, true);
    EXPECT_EQ(report.reset, ResetReason::kNone);
    if (k == 20) {
      EXPECT_EQ(
          std::count_if(report.factors.begin(), report.factors.end(),
                        [](const FactorReport& f) { return f.outcome == Outcome::kQuarantined; }),
          2);
    }
  }
  EXPECT_EQ(counted(smoother, FactorKind::kGps, Outcome::kQuarantined), 1U);
  EXPECT_EQ(counted(smoother, FactorKind::kRelativePose, Outcome::kQuarantined), 1U);
  EXPECT_LT(error(smoother, 29), 0.15);
}

TEST_F(SmootherFaultsTest, WithoutTheImuItCoastsAndSaysSo) {
  FixedLagSmoother smoother = flown(30);
  const double before = smoother.covariance(smoother.keyframes() - 1)(kVelocity, kVelocity);
  for (int k = 30; k < 33; ++k) {
    smoother.add(flight_.vision[static_cast<std::size_t>(k)]);
    const UpdateReport& report = smoother.update(SimulatedFlight::time_of(k));
    EXPECT_NEAR(report.coasted, k == 30 ? 0.07 : 0.1, 1e-6);  // after 0.03 s that are held
    EXPECT_EQ(report.reset, ResetReason::kNone);
  }
  EXPECT_GT(smoother.covariance(smoother.keyframes() - 1)(kVelocity, kVelocity), 4 * before);
  EXPECT_LT(error(smoother, 32), 0.3);
  for (std::size_t i = 320; i < 330; ++i) {
    smoother.add(flight_.imu[i]);
  }
  EXPECT_EQ(smoother.update(3.3).coasted, 0);
}

TEST_F(SmootherFaultsTest, ReportsEveryFactorInTheEquations) {
  FixedLagSmoother smoother = flown(30);
  std::vector<FactorReport> reports;
  smoother.report_factors(reports);
  const auto of = [&](FactorKind kind) {
    return std::count_if(reports.begin(), reports.end(),
                         [&](const FactorReport& r) { return r.kind == kind; });
  };
  const auto keyframes = static_cast<std::ptrdiff_t>(smoother.keyframes());
  EXPECT_EQ(of(FactorKind::kGps), keyframes);
  EXPECT_EQ(of(FactorKind::kVisualPose), keyframes);
  EXPECT_EQ(of(FactorKind::kImu), keyframes - 1);
  EXPECT_EQ(of(FactorKind::kRelativePose), keyframes - 1);
  double sum = 0;
  double degrees = 0;
  for (const FactorReport& report : reports) {
    EXPECT_EQ(report.outcome, Outcome::kAccepted);
    EXPECT_EQ(report.weight, 1);
    sum += report.chi_square;
    degrees += report.degrees;
  }
  // Chi-square of the residuals: as many degrees as rows, less the states.
  const double expected = degrees - 15.0 * static_cast<double>(keyframes);
  EXPECT_NEAR(sum, expected, 4 * std::sqrt(2 * expected));
}

}  // namespace
}  // namespace pipescout::estimation
