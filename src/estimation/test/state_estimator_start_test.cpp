// SPDX-License-Identifier: Apache-2.0
// A pose that is given to a vehicle that moves while it starts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pipescout/estimation/state_estimator.hpp"
#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SO3;
using test::SimulatedVehicle;
using test::VehicleOptions;
using testing::HasSubstr;

/// A robot on a level circle, with sensors without errors; it starts at time 0 at the origin.
struct Circle {
  double speed = 1;   // m/s
  double rate = 0.5;  // rad/s
  double heading = 0.7;
  double begin = 0;  // s: it stands before

  [[nodiscard]] double heading_at(double t) const {
    return heading + rate * std::max(t - begin, 0.0);
  }
  [[nodiscard]] Vector3d place_at(double t) const {
    const double since = std::max(t - begin, 0.0);
    if (rate == 0) {
      return speed * since * Vector3d(std::cos(heading), std::sin(heading), 0);
    }
    const double to = heading_at(t);
    return speed / rate *
           Vector3d(std::sin(to) - std::sin(heading), std::cos(heading) - std::cos(to), 0);
  }
  [[nodiscard]] GivenPose given(double t) const {
    return {.time = t,
            .position = place_at(t),
            .position_deviation = 0.01,
            .heading = heading_at(t),
            .heading_deviation = 0.01};
  }
  /// 100 Hz and 50 Hz.
  void drive(StateEstimator& estimator, double from, double until, bool odometer = true) const {
    for (int i = static_cast<int>(std::lround(100 * from)); i < std::lround(100 * until); ++i) {
      const double t = 0.01 * i;
      const bool moves = t >= begin;
      estimator.add(ImuReading{t, {0, moves ? speed * rate : 0, 9.81}, {0, 0, moves ? rate : 0}});
      if (odometer && i % 2 == 0) {
        estimator.add(OdometerReading{.time = t, .distance = speed * std::max(t - begin, 0.0)});
      }
    }
  }
  struct Off {
    double position = INFINITY;  // m
    double heading = INFINITY;   // rad
    double position_deviation = 0;
    double heading_deviation = 0;
  };
  [[nodiscard]] Off off(const StateEstimator& estimator) const {
    const auto estimate = estimator.estimate();
    if (!estimate || !estimate->in_map) {
      return {};
    }
    const double t = estimate->time;
    const StateMatrix covariance = estimator.covariance();
    const double yaw = estimate->state.R_map_body.roll_pitch_yaw().z();
    return {.position = (estimate->state.position - place_at(t)).norm(),
            .heading = std::abs(std::remainder(yaw - heading_at(t), 2 * std::numbers::pi)),
            .position_deviation = std::sqrt(covariance(kPosition, kPosition)),
            .heading_deviation = std::sqrt(covariance(kRotation + 2, kRotation + 2))};
  }
};

StateEstimatorParameters start_robot() {
  StateEstimatorParameters p = StateEstimatorParameters::ground_robot();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  return p;
}

TEST(StateEstimatorStart, AGivenPoseIsThatOfItsTimeWhileTheRobotDrivesOn) {
  VehicleOptions options;
  options.standing = -5;
  options.gps = false;
  for (const std::uint64_t seed : {13, 14, 15}) {
    const SimulatedVehicle vehicle(seed, options);
    const NavState begin = vehicle.truth(0);
    StateEstimator estimator(start_robot());
    estimator.add(GivenPose{.time = 0,
                            .position = begin.position,
                            .position_deviation = 0.05,
                            .heading = begin.R_map_body.roll_pitch_yaw().z(),
                            .heading_deviation = 0.02});
    test::deliver(estimator, vehicle, 0, 10);
    const auto estimate = estimator.estimate();
    ASSERT_TRUE(estimate && estimate->in_map);
    const StateVector d = vehicle.truth(estimate->time).local(estimate->state);
    EXPECT_LT(d.segment<3>(kPosition).norm(), 0.8) << seed;
    EXPECT_LT(d.segment<3>(kRotation).norm(), 0.07) << seed;
  }
}

/// Wheels that are heard, but not for long enough, or whose first reading is wrong: what they do
/// not tell yet is not what nobody knows.
TEST(StateEstimatorStart, AGivenPoseOfARobotThatStandsIsAsSureAsItWasWithAnOdometerThatBeginsLate) {
  const Circle circle{.begin = 20};
  for (const double odometer_from : {0.0, 0.3, 0.52, 0.7, 0.9}) {
    StateEstimator estimator(start_robot());
    estimator.add(circle.given(0));
    circle.drive(estimator, 0, odometer_from, false);
    circle.drive(estimator, odometer_from, 4);
    const Circle::Off off = circle.off(estimator);
    EXPECT_LT(off.position, 0.02) << odometer_from;
    EXPECT_LT(off.position_deviation, 0.05) << odometer_from;
  }
}

TEST(StateEstimatorStart, AGivenPoseWhileItTurns) {
  for (const double rate : {-0.5, 0.0, 0.1, 0.5}) {
    const Circle circle{.rate = rate};
    // Before the first reading, during the levelling, at its end, and after it.
    for (const double stamp : {0.0, 0.02, 0.37, 0.99, 1.0, 1.72, 3.0}) {
      StateEstimator estimator(start_robot());
      estimator.add(circle.given(stamp));
      circle.drive(estimator, 0, 5);
      EXPECT_LT(circle.off(estimator).position, 0.12) << rate << ' ' << stamp;
      EXPECT_LT(circle.off(estimator).heading, 0.03) << rate << ' ' << stamp;
    }
  }
}

TEST(StateEstimatorStart, AGivenPoseThatComesLate) {
  const Circle circle;
  for (const double stamp : {0.4, 1.2, 1.9}) {
    for (const double arrival : {0.7, 2.0, 4.5}) {
      StateEstimator estimator(start_robot());
      circle.drive(estimator, 0, arrival);
      estimator.add(circle.given(stamp));
      circle.drive(estimator, arrival, 6);
      const Circle::Off off = circle.off(estimator);
      EXPECT_LT(off.position, std::max(0.12, 3 * off.position_deviation))
          << stamp << ' ' << arrival;
      EXPECT_LT(off.heading, std::max(0.03, 3 * off.heading_deviation)) << stamp << ' ' << arrival;
    }
  }
}

TEST(StateEstimatorStart, APoseThatIsGivenWithARestartOnTheMove) {
  const Circle circle;
  for (const double age : {0.0, 0.05, 0.6}) {
    StateEstimator estimator(start_robot());
    estimator.add(circle.given(0));
    circle.drive(estimator, 0, 10);
    estimator.restart();
    estimator.add(circle.given(10 - age));
    circle.drive(estimator, 10, 14);
    EXPECT_LT(circle.off(estimator).position, 0.12) << age;
    EXPECT_LT(circle.off(estimator).heading, 0.03) << age;
  }
}

TEST(StateEstimatorStart, OdomGoesOnOverARestartOnTheMove) {
  const Circle circle;
  StateEstimator estimator(start_robot());
  estimator.add(circle.given(0));
  circle.drive(estimator, 0, 10);
  const auto before = estimator.estimate();
  estimator.restart();
  circle.drive(estimator, 10, 12);
  const auto after = estimator.estimate();
  ASSERT_TRUE(before && after);
  const geometry::SE3 moved = before->T_odom_body.inverse() * after->T_odom_body;
  const geometry::SE3 truth =
      geometry::SE3(SO3::about_z(circle.heading_at(before->time)), circle.place_at(before->time))
          .inverse() *
      geometry::SE3(SO3::about_z(circle.heading_at(after->time)), circle.place_at(after->time));
  EXPECT_LT((moved.translation() - truth.translation()).norm(), 0.1);
  EXPECT_LT((moved.rotation().inverse() * truth.rotation()).log().norm(), 0.03);
}

TEST(StateEstimatorStart, AGivenPlaceWaitsForALateHeading) {
  const Circle circle{.speed = 1, .rate = 0.1};
  StateEstimator estimator(start_robot());
  GivenPose place = circle.given(0);
  place.heading.reset();
  estimator.add(place);
  circle.drive(estimator, 0, 20);
  EXPECT_FALSE(estimator.estimate()->in_map);
  for (int i = 0; i < 50; ++i) {
    const double t = 20 + 0.1 * i;
    circle.drive(estimator, t, t + 0.1);
    estimator.add(HeadingMeasurement{t, circle.heading_at(t), 0.01});
  }
  EXPECT_LT(circle.off(estimator).position, 0.8);
  EXPECT_LT(circle.off(estimator).heading, 0.03);
}

TEST(StateEstimatorStart, AnOldPoseIsUsedOnlyOfARobotThatStood) {
  Circle circle{.begin = 100};
  StateEstimator stood(start_robot());
  stood.add(circle.given(-1000));
  circle.drive(stood, 0, 3);
  EXPECT_LT(circle.off(stood).position, 0.12);
  EXPECT_LT(circle.off(stood).heading, 0.03);

  circle.begin = -2000;
  StateEstimator moved(start_robot());
  GivenPose heading = circle.given(-1000);
  heading.position.reset();
  moved.add(heading);
  circle.drive(moved, 0, 3);
  EXPECT_EQ(moved.status().phase, Phase::kAligning);
  EXPECT_THAT(moved.status().text, HasSubstr("the given pose is not used"));

  // The deviations say what is not known: here of half a second.
  circle.begin = -1;
  StateEstimator recent(start_robot());
  recent.add(circle.given(-0.5));
  circle.drive(recent, 0, 3);
  const Circle::Off off = circle.off(recent);
  EXPECT_LT(off.position, 3 * off.position_deviation);
  EXPECT_LT(off.heading, 3 * off.heading_deviation);
}

TEST(StateEstimatorStart, AStampFarAheadIsToldAndNotUsed) {
  const Circle circle;
  StateEstimator estimator(start_robot());
  GivenPose pose = circle.given(0);
  pose.time = 1000;
  estimator.add(pose);
  circle.drive(estimator, 0, 3);
  EXPECT_EQ(estimator.status().phase, Phase::kAligning);
  EXPECT_THAT(estimator.status().text, HasSubstr("ahead of the IMU"));
  estimator.add(circle.given(3));
  circle.drive(estimator, 3, 5);
  EXPECT_LT(circle.off(estimator).position, 0.12);
}

TEST(StateEstimatorStart, WithoutAnOdometerTheSpeedIsPartOfTheUncertainty) {
  const Circle circle{.speed = 0.8, .rate = 0.1};
  StateEstimatorParameters p = StateEstimatorParameters::uav();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  StateEstimator estimator(p);
  estimator.add(circle.given(0));
  circle.drive(estimator, 0, 1.3, false);
  const Circle::Off off = circle.off(estimator);
  EXPECT_LT(off.position, 3 * off.position_deviation);
  EXPECT_LT(off.heading, 0.05);
}

TEST(StateEstimatorStart, PosesThatAreNoneAreRefused) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Circle circle;
  StateEstimator estimator(start_robot());
  const auto refused = [&](auto&& spoil, Outcome outcome) {
    GivenPose pose = circle.given(0);
    spoil(pose);
    EXPECT_EQ(estimator.add(pose), outcome);
  };
  refused([](GivenPose& pose) { pose.time = kNan; }, Outcome::kNotFinite);
  refused([](GivenPose& pose) { pose.time = INFINITY; }, Outcome::kNotFinite);
  refused([](GivenPose& pose) { pose.position->z() = kNan; }, Outcome::kNotFinite);
  refused([](GivenPose& pose) { pose.heading = INFINITY; }, Outcome::kNotFinite);
  refused([](GivenPose& pose) { pose.position_deviation = kNan; }, Outcome::kBadCovariance);
  refused([](GivenPose& pose) { pose.position_deviation = 0; }, Outcome::kBadCovariance);
  refused([](GivenPose& pose) { pose.heading_deviation = kNan; }, Outcome::kBadCovariance);
  refused([](GivenPose& pose) { pose.heading_deviation = -0.1; }, Outcome::kBadCovariance);
  refused([](GivenPose& pose) { pose.heading_deviation = 2; }, Outcome::kBadCovariance);
  circle.drive(estimator, 0, 3);
  EXPECT_FALSE(estimator.estimate()->in_map);
}

}  // namespace
}  // namespace pipescout::estimation
