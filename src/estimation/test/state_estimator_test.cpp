// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/state_estimator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SO3;
using test::AnyMessage;
using test::SimulatedVehicle;
using test::VehicleOptions;
using testing::HasSubstr;

StateEstimatorParameters robot() {
  StateEstimatorParameters p = StateEstimatorParameters::ground_robot();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  return p;
}

struct Errors {
  double position = INFINITY;  // m
  double rotation = INFINITY;  // rad
  double velocity = INFINITY;  // m/s
};

Errors errors(const StateEstimator& estimator, const SimulatedVehicle& vehicle) {
  const auto estimate = estimator.estimate();
  if (!estimate || !estimate->in_map) {
    return {};
  }
  const StateVector d = vehicle.truth(estimate->time).local(estimate->state);
  return {d.segment<3>(kPosition).norm(), d.segment<3>(kRotation).norm(),
          d.segment<3>(kVelocity).norm()};
}

TEST(StateEstimator, FindsItsHeadingFromMotionWithGps) {
  for (const double heading : {-2.0, 0.5, 3.0}) {
    VehicleOptions options;
    options.heading = heading;
    const SimulatedVehicle vehicle(11, options);
    StateEstimator estimator(robot());
    test::deliver(estimator, vehicle, 0, 0.5);
    EXPECT_EQ(estimator.status().phase, Phase::kStarting);
    EXPECT_EQ(estimator.status().waits_for, WaitsFor::kLevel);
    test::deliver(estimator, vehicle, 0.5, 4);
    EXPECT_EQ(estimator.status().phase, Phase::kAligning);
    EXPECT_EQ(estimator.status().waits_for, WaitsFor::kHeading);
    EXPECT_THAT(estimator.status().text, HasSubstr("m of motion with GPS"));
    EXPECT_TRUE(estimator.status().standing_still);
    EXPECT_FALSE(estimator.estimate()->in_map);
    test::deliver(estimator, vehicle, 4, 12);
    EXPECT_EQ(estimator.status().phase, Phase::kRunning);
    EXPECT_EQ(estimator.status().waits_for, WaitsFor::kNothing);
    EXPECT_EQ(estimator.status().of(Source::kGps).state, SourceState::kTrusted);
    EXPECT_EQ(estimator.status().of(Source::kWeld).state, SourceState::kAbsent);
    test::deliver(estimator, vehicle, 12, 60);
    EXPECT_LT(errors(estimator, vehicle).position, 0.5);
    EXPECT_LT(errors(estimator, vehicle).rotation, 0.03);
    EXPECT_LT(errors(estimator, vehicle).velocity, 0.1);
    EXPECT_GT(estimator.status().of(Source::kOdometer).accepted, 400U);
  }
}

TEST(StateEstimator, FindsItsHeadingInFlightByTheImuAlone) {
  VehicleOptions options;
  options.kind = VehicleOptions::Kind::kFly;
  options.odometer = false;
  options.heading = 2;
  const SimulatedVehicle vehicle(12, options);
  StateEstimatorParameters p = StateEstimatorParameters::uav();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  p.gps.correlation_time = 0;  // its fixes are independent
  StateEstimator estimator(p);
  test::deliver(estimator, vehicle, 0, 60);
  EXPECT_LT(errors(estimator, vehicle).position, 1.2);
  EXPECT_LT(errors(estimator, vehicle).rotation, 0.15);
}

TEST(StateEstimator, StartsWhileMovingByItsOdometer) {
  VehicleOptions options;
  options.standing = -5;
  const SimulatedVehicle vehicle(13, options);
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 60);
  EXPECT_LT(errors(estimator, vehicle).position, 0.6);
  EXPECT_LT(errors(estimator, vehicle).rotation, 0.04);
}

TEST(StateEstimator, StartsStandingStillWhenItIsToldEnough) {
  VehicleOptions options;
  options.duration = 5;
  options.standing = 10;
  options.heading = 1;
  const NavState truth = SimulatedVehicle(14, options).truth(0);
  const auto started = [&](const VehicleOptions& with, const GivenPose* given) {
    const SimulatedVehicle vehicle(14, with);
    StateEstimator estimator(robot());
    if (given != nullptr) {
      EXPECT_EQ(estimator.add(*given), Outcome::kWaiting);
    }
    test::deliver(estimator, vehicle, 0, 5);
    return errors(estimator, vehicle);
  };
  VehicleOptions compass = options;
  compass.compass = true;
  EXPECT_LT(started(compass, nullptr).position, 1);
  EXPECT_LT(started(compass, nullptr).rotation, 0.05);
  VehicleOptions vision = options;
  vision.vision = true;
  vision.gps = false;
  EXPECT_LT(started(vision, nullptr).position, 0.03);
  EXPECT_LT(started(vision, nullptr).rotation, 0.01);
  VehicleOptions nothing = options;
  nothing.gps = false;
  GivenPose given = {.time = 0, .position = truth.position, .position_deviation = 0.1};
  EXPECT_TRUE(std::isinf(started(nothing, &given).position));
  given.heading = truth.R_map_body.roll_pitch_yaw().z() + 0.02;
  EXPECT_LT(started(nothing, &given).position, 0.2);
  EXPECT_LT(started(nothing, &given).rotation, 0.04);
}

/// A robot that stands, then turns on the spot from 4 s on; rad, off its heading after a minute.
/// Sensors without errors. `stood`: rad/s, by which it turns from the beginning.
double off_after_turning_on_the_spot(double rate, double stood, bool wheels_tell) {
  StateEstimator estimator(robot());
  estimator.add(GivenPose{.time = 0,
                          .position = Vector3d::Zero(),
                          .position_deviation = 0.01,
                          .heading = 0,
                          .heading_deviation = 0.01});
  double heading = 0;
  for (int i = 0; i <= 6000; ++i) {
    const double time = 0.01 * i;
    const double turning = time < 4 ? stood : rate;
    estimator.add(ImuReading{time, {0, 0, 9.81}, {0, 0, turning}});
    if (i % 2 == 0) {
      estimator.add(OdometerReading{.time = time});
      if (wheels_tell) {
        estimator.add(WheelTurn{time, turning});
      }
    }
    heading += i < 6000 ? 0.01 * turning : 0;
  }
  return std::abs(estimator.estimate()->state.R_map_body.roll_pitch_yaw().z() - heading);
}

TEST(StateEstimator, ASlowTurnOnTheSpotIsNoGyroBiasWhereTheWheelsTell) {
  constexpr double kSlow = 0.008;  // rad/s, less than a gyro at rest may show
  EXPECT_LT(off_after_turning_on_the_spot(kSlow, 0, true), 0.02);
  EXPECT_LT(off_after_turning_on_the_spot(kSlow, kSlow, true), 0.04);
  // Nothing else on board tells it from a bias.
  EXPECT_GT(off_after_turning_on_the_spot(kSlow, 0, false), 0.3);
}

TEST(StateEstimator, WheelsThatAreNotFiniteTellNothing) {
  StateEstimator estimator(robot());
  EXPECT_EQ(estimator.add(WheelTurn{NAN, 0}), Outcome::kNotFinite);
  EXPECT_EQ(estimator.add(WheelTurn{0, INFINITY}), Outcome::kNotFinite);
  EXPECT_EQ(estimator.add(WheelTurn{0, 0}), Outcome::kAccepted);
}

/// A crawler that starts at chainage 12 and goes on by half a metre a second from 4 s on, and its
/// welds: at a time, said to be at a chainage; `off` from where it is.
struct PassedWeld {
  int centisecond;
  double off;
};

double crawl(StateEstimator& estimator, const StateEstimatorParameters& p,
             const std::vector<PassedWeld>& welds) {
  double distance = 0;
  double speed = 0;
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.01 * i;
    const double acceleration = t >= 3 && t < 4 ? 0.5 : 0;
    distance += 0.01 * speed + 0.5e-4 * acceleration;
    speed += 0.01 * acceleration;
    estimator.add(ImuReading{t, Vector3d(0.02 + acceleration, 0.01, 9.81), Vector3d(0, 0, 1e-4)});
    estimator.add(OdometerReading{t, 0.99 * distance, 1e-6 * distance});
    for (const PassedWeld& weld : welds) {
      if (weld.centisecond == i) {
        estimator.add(
            *p.centre_line->weld(t, 12 + distance + weld.off, 0.01, 0.02, Vector3d::Zero()));
      }
    }
  }
  return 12 + distance;
}

StateEstimatorParameters crawler_in_a_straight_pipe() {
  StateEstimatorParameters p = StateEstimatorParameters::crawler();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  p.centre_line.emplace(std::vector<Vector3d>{{0, 0, 5}, {0, 100, 5}});
  return p;
}

TEST(StateEstimator, ACrawlerStartsFromAWeldAndKeepsToItsLine) {
  const StateEstimatorParameters p = crawler_in_a_straight_pipe();
  StateEstimator estimator(p);
  const double chainage = crawl(estimator, p, {{200, 0}, {2700, 0}});
  const auto estimate = estimator.estimate();
  ASSERT_TRUE(estimate && estimate->in_map);
  EXPECT_LT((estimate->state.position - Vector3d(0, chainage, 5)).norm(), 0.2);
  EXPECT_NEAR(estimate->state.R_map_body.roll_pitch_yaw().z(), std::numbers::pi / 2, 0.02);
  EXPECT_GE(estimator.status().of(Source::kWeld).accepted, 1U);
  EXPECT_LT(estimator.status().of(Source::kWeld).accepted, 3U);
  EXPECT_EQ(estimator.status().of(Source::kWeld).state, SourceState::kTrusted);
  const FixedLagSmoother& smoother = estimator.smoother();
  const auto accepted = static_cast<std::size_t>(Outcome::kAccepted);
  EXPECT_LT(smoother.counts(FactorKind::kWeld)[accepted], 3U);
  // Of 28 m of way, each half metre.
  for (const FactorKind kind : {FactorKind::kCentreLine, FactorKind::kNonHolonomic}) {
    EXPECT_NEAR(static_cast<double>(smoother.counts(kind)[accepted]), 55, 6) << to_string(kind);
  }
}

TEST(StateEstimator, AWeldThatIsTakenForAnotherOneIsStillOneOfTheTally) {
  StateEstimatorParameters p = crawler_in_a_straight_pipe();
  const std::vector<PassedWeld> welds{{200, 0}, {2200, 11}, {3400, -11}, {4600, 11}, {5800, 0}};
  StateEstimator without(p);
  const double chainage = crawl(without, p, welds);
  EXPECT_EQ(without.status().of(Source::kWeld).reassigned, 0U);
  for (int weld = 0; weld < 16; ++weld) {
    p.tally.push_back(3.25 + 6 * weld);  // it is at 21.25 + 6 n at those times
  }
  StateEstimator with(p);
  crawl(with, p, welds);
  const SourceStatus status = with.status().of(Source::kWeld);
  EXPECT_EQ(status.reassigned, 3U);
  EXPECT_EQ(status.accepted, without.status().of(Source::kWeld).accepted);
  const Vector3d truth(0, chainage, 5);
  EXPECT_LT((with.estimate()->state.position - truth).norm(), 0.03);
  // They tell the scale of the odometer, which shows 0.99 of the way.
  const auto scale_error = [](const StateEstimator& estimator) {
    return std::abs(estimator.smoother().globals().odometer_scale - 1 / 0.99);
  };
  EXPECT_LT(scale_error(with), 0.5 * scale_error(without));
}

TEST(StateEstimator, AWeldThatCouldBeEitherOfTwoIsNotReassigned) {
  StateEstimatorParameters p = crawler_in_a_straight_pipe();
  p.tally = {12, 21.1, 21.25, 21.4};
  StateEstimator estimator(p);
  crawl(estimator, p, {{200, 0}, {1000, 0}, {2200, 11}});
  EXPECT_EQ(estimator.status().of(Source::kWeld).reassigned, 0U);
}

TEST(StateEstimator, WhatItIsNotToldInALongWhileIsNotMixedWithTheRest) {
  // Nothing tells the heading for 20 minutes; a stop then tells the bias of the gyro, which turns
  // all that is known of the heading, by far more than what is linear.
  VehicleOptions options;
  options.gps = false;
  options.speed = 0.3;
  options.imu_rate = 50;
  options.duration = 1200;
  options.stop_from = 720;
  options.stop_until = 740;
  StateEstimatorParameters p = StateEstimatorParameters::crawler();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  p.smoother.imu_noise.gyro_bias = 2e-4;
  for (const std::uint64_t seed : {3, 4}) {
    const SimulatedVehicle vehicle(seed, options);
    StateEstimator estimator(p);
    double worst = 0;
    test::deliver(
        estimator, vehicle, 0, options.duration,
        [&](AnyMessage& message) {
          if (auto* const imu = std::get_if<ImuReading>(&message)) {
            imu->angular_rate.z() += 1e-5 * std::min(imu->time, options.duration - imu->time);
          }
          return true;
        },
        [&](const Estimate& estimate) {
          if (estimate.time > 10) {
            const double truth = vehicle.truth(estimate.time).velocity.norm();
            worst = std::max(worst, std::abs(estimate.state.velocity.norm() - truth));
          }
        });
    EXPECT_LT(worst, 0.04) << "seed " << seed;
    EXPECT_EQ(estimator.status().phase, Phase::kAligning);
    for (const std::size_t restarts : estimator.status().restarts) {
      EXPECT_EQ(restarts, 0U) << "seed " << seed;
    }
  }
}

/// How far off the level is after `duration` s of hovering in gusts, and what is stated, rad.
struct Level {
  double error = INFINITY;
  double deviation = INFINITY;
};

Level level_in_hover(double hover_speed, double duration) {
  StateEstimatorParameters p = StateEstimatorParameters::uav();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  p.start.hover_speed = hover_speed;
  StateEstimator estimator(p);
  for (int i = 0; i <= std::lround(200 * duration); ++i) {
    // To and fro at up to 7 cm/s; no gust has ended when the levelling does.
    const double time = i / 200.0;
    const Vector3d force(0.1 * std::cos(1.5 * time), 0.05 * std::cos(time + 1), 9.80665);
    estimator.add(ImuReading{.time = time,
                             .specific_force = SO3::about_z(-0.1 * std::sin(3 * time)) * force,
                             .angular_rate = {0, 0, 0.3 * std::cos(3 * time)}});
  }
  const auto estimate = estimator.estimate();
  if (!estimate || estimate->in_map) {
    return {};
  }
  const Eigen::Matrix3d covariance = estimator.covariance().block<3, 3>(kRotation, kRotation);
  const Vector3d up = estimate->state.R_map_body.inverse() * Vector3d::UnitZ();
  return {std::acos(std::min(1.0, up.z())), std::sqrt(covariance.diagonal().head<2>().maxCoeff())};
}

TEST(StateEstimator, LevelsItselfInTheAirWhenItIsSaidToHover) {
  EXPECT_NEAR(level_in_hover(0, 5).deviation, 0.1, 0.05);
  const Level hovering = level_in_hover(0.05, 5);
  EXPECT_LT(hovering.deviation, 0.02);
  EXPECT_LT(hovering.error, 2 * hovering.deviation);
}

TEST(StateEstimator, OdomNeverJumpsAndBothFramesAgree) {
  VehicleOptions options;
  options.duration = 80;
  const SimulatedVehicle vehicle(15, options);
  StateEstimator estimator(robot());
  std::optional<Estimate> last;
  double farthest = 0;
  double most_turned = 0;
  double map_jump = 0;
  test::deliver(
      estimator, vehicle, 0, 80,
      [&](AnyMessage& message) {
        auto* const gps = std::get_if<GpsMeasurement>(&message);
        return gps == nullptr || gps->time < 30 || gps->time > 60;
      },
      [&](const Estimate& estimate) {
        const geometry::SE3 apart =
            (estimate.T_map_odom * estimate.T_odom_body).inverse() * estimate.state.T_map_body();
        EXPECT_LT(apart.log().norm(), 1e-9);
        if (last && estimate.time > last->time) {
          const geometry::SE3 step = last->T_odom_body.inverse() * estimate.T_odom_body;
          farthest = std::max(farthest, step.translation().norm());
          most_turned = std::max(most_turned, step.rotation().log().norm());
        }
        if (last && last->in_map && estimate.in_map) {
          map_jump = std::max(map_jump, (estimate.state.position - last->state.position).norm());
        }
        last = estimate;
      });
  EXPECT_LT(farthest, 0.01 * 6.5);  // at up to 4.4 m/s, 10 ms apart
  EXPECT_LT(most_turned, 0.02);
  EXPECT_GT(map_jump, 0.06);  // as it may
}

TEST(StateEstimator, RepeatsItselfBitForBit) {
  VehicleOptions options;
  options.duration = 20;
  const SimulatedVehicle vehicle(16, options);
  StateEstimator one(robot());
  StateEstimator other(robot());
  test::deliver(one, vehicle, 0, 20);
  test::deliver(other, vehicle, 0, 20);
  EXPECT_EQ(one.estimate()->state.position, other.estimate()->state.position);
  EXPECT_EQ(one.covariance(), other.covariance());
}

TEST(StateEstimator, ParametersOutOfRangeAreRefusedByName) {
  const auto refused = [](const std::function<void(StateEstimatorParameters&)>& change) {
    StateEstimatorParameters p;
    change(p);
    try {
      const StateEstimator estimator(p);
    } catch (const std::invalid_argument& wrong) {
      return std::string(wrong.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused([](auto& /*p*/) {}), "accepted");
  EXPECT_THAT(refused([](auto& p) { p.keyframe_period = 0; }), HasSubstr("keyframe_period: 0"));
  EXPECT_THAT(refused([](auto& p) { p.keyframe_period = NAN; }), HasSubstr("keyframe_period"));
  EXPECT_THAT(refused([](auto& p) { p.smoother.lag = -1; }), HasSubstr("smoother.lag: -1"));
  EXPECT_THAT(refused([](auto& p) { p.start.levelling = 100; }), HasSubstr("start.levelling"));
  EXPECT_THAT(refused([](auto& p) { p.gps.outage = 0; }), HasSubstr("gps.outage"));
  EXPECT_THAT(refused([](auto& p) { p.weld.agreeing = 1; }), HasSubstr("weld.agreeing"));
  EXPECT_THAT(refused([](auto& p) { p.odometer.no_consensus_factor = 0.5; }),
              HasSubstr("no_consensus_factor"));
  EXPECT_THAT(refused([](auto& p) { p.standstill.window = 0; }), HasSubstr("standstill.window"));
  EXPECT_THAT(refused([](auto& p) { p.lateral_deviation = 0.1; }), HasSubstr("vertical_deviation"));
  EXPECT_THAT(refused([](auto& p) { p.lateral_correlation = NAN; }),
              HasSubstr("lateral_correlation"));
  EXPECT_THAT(refused([](auto& p) { p.centre_line_correlation = -1; }),
              HasSubstr("centre_line_correlation: -1"));
  EXPECT_THAT(refused([](auto& p) { p.tally = {1, 2}; }), HasSubstr("tally"));
  const auto with_tally = [&](const std::vector<double>& tally) {
    return refused([&](auto& p) {
      p.centre_line.emplace(std::vector<Vector3d>{{0, 0, 0}, {10, 0, 0}});
      p.tally = tally;
    });
  };
  EXPECT_EQ(with_tally({0, 5, 10}), "accepted");
  EXPECT_THAT(with_tally({0, 5, 5}), HasSubstr("tally[2]: 5"));
  EXPECT_THAT(with_tally({0, 5, 11}), HasSubstr("tally[2]: 11"));
  EXPECT_THAT(with_tally({0, NAN}), HasSubstr("tally[1]"));
  EXPECT_THAT(refused([](auto& p) { p.specific_force_scale = 0; }),
              HasSubstr("specific_force_scale"));
}

TEST(StateEstimator, NamesAreNames) {
  EXPECT_EQ(to_string(Source::kVisualPose), "visual_pose");
  EXPECT_EQ(to_string(Phase::kCoasting), "coasting");
  EXPECT_EQ(to_string(WaitsFor::kPlace), "place");
  EXPECT_EQ(to_string(RestartReason::kTakenOver), "taken_over");
  EXPECT_EQ(to_string(SourceState::kDoubted), "doubted");
  EXPECT_EQ(to_string(static_cast<Phase>(77)), "unknown");
}

}  // namespace
}  // namespace pipescout::estimation
