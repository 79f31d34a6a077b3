// SPDX-License-Identifier: Apache-2.0
// What no estimator may fall over.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SO3;
using test::AnyMessage;
using test::SimulatedVehicle;
using test::VehicleOptions;
using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

StateEstimatorParameters robot() {
  StateEstimatorParameters p = StateEstimatorParameters::ground_robot();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  return p;
}

double error(const StateEstimator& estimator, const SimulatedVehicle& vehicle, double ahead = 0) {
  const auto estimate = estimator.estimate();
  if (!estimate || !estimate->in_map) {
    return INFINITY;
  }
  return (estimate->state.position - vehicle.truth(estimate->time - ahead).position).norm();
}

std::size_t restarts(const StateEstimator& estimator, RestartReason reason) {
  return estimator.status().restarts[static_cast<std::size_t>(reason)];
}

/// The same message so much later.
AnyMessage later(AnyMessage message, double by) {
  std::visit([&](auto& m) { m.time += by; }, message);
  return message;
}

class StateEstimatorFaultsTest : public testing::Test {
 protected:
  StateEstimatorFaultsTest() {
    options_.duration = 90;
    options_.heading = 0.4;
    options_.compass = true;
  }
  /// Delivers with times moved by `ahead`.
  static void deliver(StateEstimator& estimator, const SimulatedVehicle& vehicle, double from,
                      double until, double ahead) {
    test::deliver(estimator, vehicle, from, until, [&](AnyMessage& message) {
      message = later(message, ahead);
      return true;
    });
  }
  VehicleOptions options_;
};

struct Mounting {
  double scale;
  SO3 turn;
  const char* text;
};

class MountingTest : public testing::TestWithParam<Mounting> {};

TEST_P(MountingTest, GravityShowsWhatIsWrongAndTheParameterMendsIt) {
  const Mounting& mounting = GetParam();
  VehicleOptions options;
  options.duration = 20;
  options.compass = true;
  const SimulatedVehicle vehicle(21, options);
  const auto mount = [&](AnyMessage& message) {
    if (auto* const imu = std::get_if<ImuReading>(&message)) {
      imu->specific_force = mounting.turn * (imu->specific_force / mounting.scale);
      imu->angular_rate = mounting.turn * imu->angular_rate;
    }
    return true;
  };
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 3, mount);
  const EstimatorStatus status = estimator.status();
  EXPECT_EQ(status.phase, Phase::kFault);
  EXPECT_EQ(status.waits_for, WaitsFor::kMounting);
  EXPECT_THAT(status.text, HasSubstr(mounting.text));
  EXPECT_FALSE(estimator.estimate());
  test::deliver(estimator, vehicle, 3, 20, mount);
  EXPECT_FALSE(estimator.estimate());

  StateEstimatorParameters mended = robot();
  mended.specific_force_scale = mounting.scale;
  mended.R_body_imu = mounting.turn.inverse();
  StateEstimator sound(mended);
  test::deliver(sound, vehicle, 0, 20, mount);
  EXPECT_LT(error(sound, vehicle), 1);
}

INSTANTIATE_TEST_SUITE_P(
    Faults, MountingTest,
    testing::Values(Mounting{9.80665, SO3(), "set specific_force_scale to 9.80665"},
                    Mounting{1, SO3::about_x(std::numbers::pi), "upside down"},
                    Mounting{1, SO3::about_x(std::numbers::pi / 2), "the IMU's -y axis up"},
                    Mounting{1, SO3::about_y(std::numbers::pi / 2), "R_body_imu"},
                    Mounting{2, SO3(), "set specific_force_scale to"}));

TEST_F(StateEstimatorFaultsTest, AnImuWithoutGravityIsTold) {
  VehicleOptions options;
  options.duration = 5;
  const SimulatedVehicle vehicle(22, options);
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 3, [](AnyMessage& message) {
    if (auto* const imu = std::get_if<ImuReading>(&message)) {
      imu->specific_force.z() -= 9.81;
    }
    return true;
  });
  EXPECT_EQ(estimator.status().phase, Phase::kFault);
  EXPECT_THAT(estimator.status().text, HasSubstr("no gravity: it has been taken out"));
}

TEST_F(StateEstimatorFaultsTest, DeadReadingsAreRefusedAndTheStateRecovers) {
  for (const bool accelerometer : {true, false}) {
    VehicleOptions options;
    options.duration = 90;
    options.compass = true;
    const SimulatedVehicle vehicle(23, options);
    StateEstimator estimator(robot());
    std::optional<Vector3d> frozen;
    test::deliver(estimator, vehicle, 0, 90, [&](AnyMessage& message) {
      auto* const imu = std::get_if<ImuReading>(&message);
      if (imu == nullptr || imu->time < 40 || imu->time > (accelerometer ? 40.25 : 42)) {
        return true;
      }
      if (accelerometer) {
        imu->specific_force.setZero();
      } else {
        frozen = frozen.value_or(imu->angular_rate);
        imu->angular_rate = *frozen;
      }
      return true;
    });
    EXPECT_GT(estimator.status().of(Source::kImu).refused, 20U);
    EXPECT_LT(error(estimator, vehicle), 1);
    const NavState truth = vehicle.truth(estimator.estimate()->time);
    const double tilt =
        (truth.R_map_body.inverse() * Vector3d::UnitZ())
            .cross(estimator.estimate()->state.R_map_body.inverse() * Vector3d::UnitZ())
            .norm();
    EXPECT_LT(tilt, 0.02) << (accelerometer ? "accelerometer" : "gyro");
  }
}

TEST_F(StateEstimatorFaultsTest, AnImuSaidToBeWorseThanAnyHoldsNothingUp) {
  // A heading that is anybody's guess within a keyframe: updates fail, and from the same keyframe
  // they fail again.
  const SimulatedVehicle vehicle(3, options_);
  StateEstimatorParameters p = StateEstimatorParameters::crawler();
  p.smoother.imu_noise = {.gyro = 10,
                          .accelerometer = 1e-9,
                          .gyro_bias = 1e-9,
                          .accelerometer_bias = 1e-9,
                          .integration = 1e-9};
  StateEstimator estimator(p);
  test::deliver(estimator, vehicle, 0, 30);
  EXPECT_GT(estimator.updates(), 100U);
}

TEST_F(StateEstimatorFaultsTest, SaysThatTheImuNeverCame) {
  const SimulatedVehicle vehicle(22, options_);
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 20,
                [](AnyMessage& message) { return !std::holds_alternative<ImuReading>(message); });
  EXPECT_EQ(estimator.status().phase, Phase::kStarting);
  EXPECT_EQ(estimator.status().waits_for, WaitsFor::kImu);
  EXPECT_GT(estimator.status().of(Source::kGps).held, 0U);
}

TEST_F(StateEstimatorFaultsTest, CoastsOnTheOdometerWhileTheImuIsSilent) {
  const SimulatedVehicle vehicle(23, options_);
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 40);
  const auto no_imu = [](AnyMessage& message) {
    return !std::holds_alternative<ImuReading>(message);
  };
  test::deliver(estimator, vehicle, 40, 50, no_imu);
  EXPECT_EQ(estimator.status().phase, Phase::kCoasting);
  EXPECT_GT(estimator.estimate()->time, 49.5);
  EXPECT_LT(error(estimator, vehicle), 2);
  test::deliver(estimator, vehicle, 50, 60);
  EXPECT_EQ(estimator.status().phase, Phase::kRunning);
  EXPECT_LT(error(estimator, vehicle), 1);
  test::deliver(estimator, vehicle, 60, 90);
  EXPECT_LT(error(estimator, vehicle), 0.7);
}

TEST_F(StateEstimatorFaultsTest, AfterTenMinutesWithoutTheImuItStartsAgain) {
  options_.duration = 700;
  options_.imu_rate = 50;
  const SimulatedVehicle vehicle(24, options_);
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 30);
  const auto before = estimator.estimate()->T_odom_body;
  test::deliver(estimator, vehicle, 30, 630,
                [](AnyMessage& message) { return !std::holds_alternative<ImuReading>(message); });
  EXPECT_EQ(estimator.status().phase, Phase::kStarting);
  EXPECT_EQ(estimator.status().waits_for, WaitsFor::kImu);
  EXPECT_EQ(restarts(estimator, RestartReason::kLost), 1U);
  test::deliver(estimator, vehicle, 630, 632);
  ASSERT_TRUE(estimator.estimate());
  // Coasting has taken it on by 30 s of driving; from there on it goes on.
  EXPECT_LT((estimator.estimate()->T_odom_body.translation() - before.translation()).norm(), 150);
  test::deliver(estimator, vehicle, 632, 700);
  EXPECT_LT(error(estimator, vehicle), 1);
}

TEST_F(StateEstimatorFaultsTest, AGpsThatIsSilentForTenMinutesIsTakenUpAgain) {
  options_.duration = 700;
  options_.imu_rate = 50;
  const SimulatedVehicle vehicle(25, options_);
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 700, [](AnyMessage& message) {
    const auto* const gps = std::get_if<GpsMeasurement>(&message);
    return gps == nullptr || gps->time < 60 || gps->time > 660;
  });
  EXPECT_EQ(estimator.status().of(Source::kGps).state, SourceState::kTrusted);
  EXPECT_LT(error(estimator, vehicle), 1);
}

TEST_F(StateEstimatorFaultsTest, JumpsOfTimeGoOnFromTheLastStateOrStartAgain) {
  const SimulatedVehicle vehicle(26, options_);
  for (const double step : {5.0, -5.0, 3600.0, -3600.0}) {
    StateEstimator estimator(robot());
    test::deliver(estimator, vehicle, 0, 30);
    deliver(estimator, vehicle, 30, 35, step);
    const bool is_short = std::abs(step) < 10;
    EXPECT_EQ(restarts(estimator, !is_short  ? RestartReason::kLost
                                  : step > 0 ? RestartReason::kTimeJumpForwards
                                             : RestartReason::kTimeJumpBackwards),
              1U)
        << step;
    if (is_short) {
      EXPECT_LT(error(estimator, vehicle, step), 1.5) << step;
    }
    deliver(estimator, vehicle, 35, 60, step);
    EXPECT_LT(error(estimator, vehicle, step), 1) << step;
    EXPECT_LT(std::abs(estimator.estimate()->time - 60 - step), 0.1);
  }
}

TEST_F(StateEstimatorFaultsTest, OneWrongStampMovesNothing) {
  const SimulatedVehicle vehicle(27, options_);
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 30);
  for (const double step : {1e3, -1e3, 1e9, 20.0}) {
    test::deliver(estimator, later(ImuReading{30, Vector3d(0, 0, 9.81), Vector3d::Zero()}, step));
    test::deliver(estimator, later(OdometerReading{30, 50, 1e-4}, step));
    test::deliver(estimator,
                  later(GpsMeasurement{30, {100, 0, 0}, Eigen::Matrix3d::Identity()}, step));
  }
  test::deliver(estimator, vehicle, 30, 40);
  const EstimatorStatus status = estimator.status();
  EXPECT_EQ(status.last_restart, RestartReason::kNone);
  EXPECT_LT(error(estimator, vehicle), 0.8);
  EXPECT_GE(status.of(Source::kImu).refused, 4U);
  EXPECT_GE(status.of(Source::kGps).refused, 4U);
}

TEST_F(StateEstimatorFaultsTest, BadNumbersAndDuplicatesAreCounted) {
  const SimulatedVehicle vehicle(28, options_);
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 20);
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  EXPECT_EQ(estimator.add(ImuReading{kNan, Vector3d::Zero(), Vector3d::Zero()}),
            Outcome::kNotFinite);
  EXPECT_EQ(estimator.add(ImuReading{20, Vector3d(0, 0, kNan), Vector3d::Zero()}),
            Outcome::kNotFinite);
  EXPECT_EQ(estimator.add(ImuReading{20, Vector3d(0, 0, 1e5), Vector3d::Zero()}), Outcome::kGated);
  EXPECT_EQ(estimator.add(ImuReading{19.99, Vector3d(0, 0, 9.81), Vector3d::Zero()}),
            Outcome::kDuplicate);
  EXPECT_EQ(estimator.add(ImuReading{19.95, Vector3d(0, 0, 9.81), Vector3d::Zero()}),
            Outcome::kLate);
  EXPECT_EQ(estimator.add(OdometerReading{19.99, kNan, 0}), Outcome::kNotFinite);
  EXPECT_EQ(estimator.add(OdometerReading{19.99, 1, -1}), Outcome::kBadCovariance);
  EXPECT_EQ(estimator.add(OdometerReading{19.98, 1, 1}), Outcome::kDuplicate);
  EXPECT_EQ(estimator.add(GpsMeasurement{19.99, {kNan, 0, 0}, unit}), Outcome::kNotFinite);
  EXPECT_EQ(estimator.add(GpsMeasurement{19.99, {0, 0, 0}, 0 * unit}), Outcome::kBadCovariance);
  EXPECT_EQ(estimator.add(HeadingMeasurement{19.99, 0, 0}), Outcome::kBadCovariance);
  EXPECT_EQ(estimator.add(GpsMeasurement{10, {0, 0, 0}, unit}), Outcome::kLate);
  EXPECT_EQ(estimator.add(GivenPose{.time = 20, .position = Vector3d(kNan, 0, 0)}),
            Outcome::kNotFinite);
  EXPECT_EQ(estimator.add(GivenPose{.time = 20, .heading = 0, .heading_deviation = 0}),
            Outcome::kBadCovariance);
  const EstimatorStatus status = estimator.status();
  EXPECT_EQ(status.of(Source::kImu).refused, 5U);
  EXPECT_EQ(status.of(Source::kOdometer).refused, 3U);
  EXPECT_EQ(status.of(Source::kGps).refused, 3U);
  EXPECT_EQ(status.of(Source::kGps).last_refusal, Outcome::kLate);
  EXPECT_LT(error(estimator, vehicle), 0.8);
}

TEST_F(StateEstimatorFaultsTest, DisorderDropsAndAChangedRateDoLittle) {
  const SimulatedVehicle vehicle(29, options_);
  StateEstimator estimator(robot());
  std::mt19937_64 engine(29);
  std::uniform_real_distribution<double> uniform;
  std::vector<test::Message> messages = vehicle.messages();
  for (test::Message& message : messages) {
    const bool imu = std::holds_alternative<ImuReading>(message.content);
    message.arrival += imu ? 0 : 0.5 * uniform(engine);
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
  int imu_count = 0;
  for (const test::Message& message : messages) {
    if (std::holds_alternative<ImuReading>(message.content)) {
      const bool half_rate = message.arrival > 30 && message.arrival < 60 && ++imu_count % 2 == 0;
      const bool gap = std::fmod(message.arrival, 10) < 0.2;
      if (half_rate || gap) {
        continue;
      }
    }
    test::deliver(estimator, message.content);
    if (uniform(engine) < 0.1) {
      test::deliver(estimator, message.content);
    }
  }
  EXPECT_LT(error(estimator, vehicle), 1);
  EXPECT_EQ(estimator.status().last_restart, RestartReason::kNone);
}

TEST_F(StateEstimatorFaultsTest, ACounterThatStartsAgainAndNoConsensusAreBridged) {
  const SimulatedVehicle vehicle(30, options_);
  StateEstimator estimator(robot());
  double zero = 0;
  test::deliver(estimator, vehicle, 0, 90, [&](AnyMessage& message) {
    if (auto* const odometer = std::get_if<OdometerReading>(&message)) {
      if (zero == 0 && odometer->time >= 40) {
        zero = odometer->distance;
      }
      odometer->distance -= zero;
      if (odometer->time > 60 && odometer->time < 65) {
        odometer->status = OdometerStatus::kNoData;
        odometer->distance += 3;
      } else if (odometer->time > 65 && odometer->time < 70) {
        odometer->status = OdometerStatus::kNoConsensus;
      }
    }
    return true;
  });
  EXPECT_LT(error(estimator, vehicle), 0.7);
  EXPECT_EQ(estimator.status().last_restart, RestartReason::kNone);
}

TEST_F(StateEstimatorFaultsTest, RestartForgetsTheState) {
  const SimulatedVehicle vehicle(31, options_);
  StateEstimator estimator(robot());
  test::deliver(estimator, vehicle, 0, 30);
  estimator.restart();
  EXPECT_FALSE(estimator.estimate());
  EXPECT_TRUE(estimator.covariance().isZero(0));
  test::deliver(estimator, vehicle, 30, 60);
  EXPECT_LT(error(estimator, vehicle), 1);
}

}  // namespace
}  // namespace pipescout::estimation
