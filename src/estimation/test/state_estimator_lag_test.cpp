// SPDX-License-Identifier: Apache-2.0
// Inputs that get lost, or lag behind one another.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "heap_guard.hpp"
#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

using test::AnyMessage;
using test::Message;
using test::SimulatedVehicle;
using test::VehicleOptions;

StateEstimatorParameters robot() {
  StateEstimatorParameters p = StateEstimatorParameters::ground_robot();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  return p;
}

VehicleOptions drive() {
  VehicleOptions options;
  options.duration = 90;
  options.heading = 0.4;
  options.compass = true;
  return options;
}

template <class Kind>
bool is(const Message& message) {
  return std::holds_alternative<Kind>(message.content);
}

/// Those of a kind come so much later than they would.
template <class Kind>
std::vector<Message> delayed(std::vector<Message> messages, double by) {
  for (Message& message : messages) {
    message.arrival += is<Kind>(message) ? by : 0;
  }
  std::ranges::stable_sort(messages, {}, &Message::arrival);
  return messages;
}

/// Without a share of those of a kind, in bursts of up to `longest` s.
template <class Kind>
std::vector<Message> thinned(std::vector<Message> messages, double share, double longest,
                             std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform;
  double begin = 0;
  double end = 0;
  std::erase_if(messages, [&](const Message& message) {
    if (!is<Kind>(message)) {
      return false;
    }
    if (message.arrival > end) {
      const double burst = longest * uniform(engine);
      begin = message.arrival + 2 * uniform(engine) * burst * (1 - share) / share;
      end = begin + burst;
    }
    return message.arrival >= begin;
  });
  return messages;
}

struct Drive {
  double rms = 0;      // m, of the position after 20 s
  double largest = 0;  // m
  double covered = 0;  // share of it within the stated 95 %
  EstimatorStatus status_when_settled{};
  EstimatorStatus status{};
};

Drive run(const StateEstimatorParameters& parameters, const SimulatedVehicle& vehicle,
          const std::vector<Message>& messages) {
  constexpr double kSettled = 20;     // s
  constexpr double kQuantile = 7.81;  // of chi-square, 3 degrees, 95 %
  StateEstimator estimator(parameters);
  Drive run;
  std::size_t count = 0;
  std::size_t covered = 0;
  std::uint64_t updates = 0;
  double squares = 0;
  for (const Message& message : messages) {
    test::deliver(estimator, message.content);
    const auto estimate = estimator.estimate();
    if (!estimate || !estimate->in_map || estimate->time < kSettled) {
      run.status_when_settled = estimator.status();
      continue;
    }
    if (std::exchange(updates, estimator.updates()) == estimator.updates()) {
      continue;
    }
    const Eigen::Vector3d error = estimate->state.position - vehicle.truth(estimate->time).position;
    const Eigen::Matrix3d covariance = estimator.covariance().topLeftCorner<3, 3>();
    ++count;
    covered += error.dot(covariance.inverse() * error) < kQuantile ? 1U : 0U;
    squares += error.squaredNorm();
    run.largest = std::max(run.largest, error.norm());
  }
  run.rms = std::sqrt(squares / static_cast<double>(count));
  run.covered = static_cast<double>(covered) / static_cast<double>(count);
  run.status = estimator.status();
  return run;
}

std::size_t lost(const Drive& run) {
  return run.status.restarts[static_cast<std::size_t>(RestartReason::kLost)];
}

void expect_as_good(const Drive& whole, const Drive& got, double factor) {
  EXPECT_LT(got.rms, factor * whole.rms);
  EXPECT_GT(got.covered, 0.88);
  EXPECT_EQ(got.status.last_restart, RestartReason::kNone) << to_string(got.status.last_restart);
  for (const Source source : {Source::kOdometer, Source::kGps, Source::kHeading}) {
    // What was measured before the start comes too late for it.
    EXPECT_EQ(got.status.of(source).refused, got.status_when_settled.of(source).refused)
        << to_string(source) << ": " << to_string(got.status.of(source).last_refusal);
  }
}

class AnImuThatIsBehind : public testing::TestWithParam<double> {};

TEST_P(AnImuThatIsBehind, IsWaitedFor) {
  const SimulatedVehicle vehicle(41, drive());
  const Drive whole = run(robot(), vehicle, vehicle.messages());
  const Drive late = run(robot(), vehicle, delayed<ImuReading>(vehicle.messages(), GetParam()));
  expect_as_good(whole, late, 1.5);
  EXPECT_NEAR(late.status.imu_gaps.behind, GetParam(), 0.1);
  EXPECT_GT(late.status.of(Source::kOdometer).waiting, 0U);
  EXPECT_EQ(late.status.imu_gaps.count, 0U);
  EXPECT_NEAR(late.status.imu_gaps.bridged, 0, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Lag, AnImuThatIsBehind, testing::Values(0.5, 1.5, 4.0));

TEST(InputsThatLag, AnImuThatComesInBundlesIsWaitedFor) {
  const SimulatedVehicle vehicle(42, drive());
  const Drive whole = run(robot(), vehicle, vehicle.messages());
  std::vector<Message> messages = vehicle.messages();
  for (Message& message : messages) {
    if (is<ImuReading>(message)) {
      message.arrival = 0.5 * std::ceil(message.arrival / 0.5);
    }
  }
  std::ranges::stable_sort(messages, {}, &Message::arrival);
  expect_as_good(whole, run(robot(), vehicle, messages), 1.5);
}

TEST(InputsThatLag, AnImuThatLosesReadingsInBurstsAndIsBehindKeepsNobodyOut) {
  const SimulatedVehicle vehicle(43, drive());
  const Drive whole = run(robot(), vehicle, vehicle.messages());
  for (const double lag : {0.5, 2.0}) {
    const Drive thin =
        run(robot(), vehicle,
            delayed<ImuReading>(thinned<ImuReading>(vehicle.messages(), 0.27, 1.5, 43), lag));
    expect_as_good(whole, thin, 1.5);
    EXPECT_GT(thin.status.imu_gaps.count, 5U);
    EXPECT_NEAR(thin.status.imu_gaps.total, 0.27 * 90, 8);
    EXPECT_LT(thin.status.imu_gaps.longest, 1.6);
    EXPECT_NEAR(thin.status.imu_gaps.bridged, thin.status.imu_gaps.total, 2);
  }
}

TEST(InputsThatLag, BeyondTheLongestWaitTheOthersGoOnWithoutTheImu) {
  const SimulatedVehicle vehicle(44, drive());
  const Drive late = run(robot(), vehicle, [&] {
    std::vector<Message> messages = vehicle.messages();
    for (Message& message : messages) {
      message.arrival += is<ImuReading>(message) && message.arrival > 40 ? 8 : 0;
    }
    std::erase_if(messages, [](const Message& message) { return message.arrival > 90; });
    std::ranges::stable_sort(messages, {}, &Message::arrival);
    return messages;
  }());
  EXPECT_EQ(late.status.of(Source::kOdometer).refused, 0U);
  EXPECT_EQ(late.status.of(Source::kGps).refused, 0U);
  EXPECT_EQ(lost(late), 0U);
  EXPECT_EQ(late.status.phase, Phase::kCoasting);
  EXPECT_GT(late.covered, 0.88);
  EXPECT_LT(late.largest, 2);
}

TEST(InputsThatLag, AnImuThatStopsAndReturnsIsAGapNotAJumpOfTime) {
  const SimulatedVehicle vehicle(45, drive());
  const Drive whole = run(robot(), vehicle, vehicle.messages());
  for (const double lag : {0.0, 0.5}) {
    std::vector<Message> messages = delayed<ImuReading>(vehicle.messages(), lag);
    std::erase_if(messages, [&](const Message& message) {
      const double time = message.arrival - lag;
      return is<ImuReading>(message) && time >= 50 && time < 52;
    });
    const Drive stopped = run(robot(), vehicle, messages);
    expect_as_good(whole, stopped, 1.3);
    EXPECT_EQ(stopped.status.imu_gaps.count, 1U) << lag;
    EXPECT_NEAR(stopped.status.imu_gaps.longest, 2, 0.05) << lag;
    EXPECT_EQ(stopped.status.phase, Phase::kRunning) << lag;
    EXPECT_LE(stopped.status.of(Source::kImu).refused, 1U) << lag;
  }
}

TEST(InputsThatLag, AGapOfAllSensorsIsBridgedByDeadMotion) {
  const SimulatedVehicle vehicle(46, drive());
  std::vector<Message> messages = vehicle.messages();
  std::erase_if(messages, [](const Message& m) { return m.arrival >= 50 && m.arrival < 51.8; });
  const Drive stopped = run(robot(), vehicle, messages);
  EXPECT_EQ(stopped.status.last_restart, RestartReason::kNone);
  EXPECT_GT(stopped.covered, 0.88);
  EXPECT_EQ(stopped.status.imu_gaps.count, 1U);
}

template <class Kind>
void expect_that_its_lag_does_little(Source source) {
  const SimulatedVehicle vehicle(47, drive());
  const Drive whole = run(robot(), vehicle, vehicle.messages());
  const Drive late = run(robot(), vehicle, delayed<Kind>(vehicle.messages(), 0.5));
  EXPECT_GT(late.status.of(source).accepted, whole.status.of(source).accepted * 9 / 10);
  expect_as_good(whole, late, 1.3);
}

TEST(InputsThatLag, AnOdometerThatIsBehindIsUsed) {
  expect_that_its_lag_does_little<OdometerReading>(Source::kOdometer);
}

TEST(InputsThatLag, AGpsThatIsBehindIsUsed) {
  expect_that_its_lag_does_little<GpsMeasurement>(Source::kGps);
}

TEST(InputsThatLag, AHeadingThatIsBehindIsUsed) {
  expect_that_its_lag_does_little<HeadingMeasurement>(Source::kHeading);
}

TEST(InputsThatLag, InTheAirTheyAreUsedToo) {
  VehicleOptions options = drive();
  options.kind = VehicleOptions::Kind::kFly;
  options.odometer = false;
  options.vision = true;
  const SimulatedVehicle vehicle(48, options);
  StateEstimatorParameters p = StateEstimatorParameters::uav();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  const Drive whole = run(p, vehicle, vehicle.messages());
  for (const auto& messages : {delayed<ImuReading>(vehicle.messages(), 0.5),
                               delayed<VisualPoseMeasurement>(vehicle.messages(), 0.5),
                               delayed<GpsMeasurement>(vehicle.messages(), 0.5)}) {
    const Drive late = run(p, vehicle, messages);
    // What is late corrects only the past, until then the IMU goes on alone.
    expect_as_good(whole, late, 2);
    EXPECT_EQ(late.status.of(Source::kVisualPose).refused,
              late.status_when_settled.of(Source::kVisualPose).refused);
  }
}

TEST(InputsThatLag, WhatWaitsIsBoundedAndCounted) {
  const SimulatedVehicle vehicle(49, drive());
  StateEstimatorParameters p = robot();
  p.longest_wait = 60;
  StateEstimator estimator(p);
  test::deliver(estimator, vehicle, 0, 30);
  // The IMU hardly comes on, but it comes.
  double imu = 30;
  std::size_t refused = 0;
  for (int i = 1; i <= 4000; ++i) {
    const double time = 30 + 0.01 * i;
    refused +=
        estimator.add(GpsMeasurement{.time = time,
                                     .position = vehicle.truth(time).position,
                                     .covariance = Eigen::Matrix3d::Identity()}) == Outcome::kFull
            ? 1U
            : 0U;
    if (i % 10 == 0) {
      imu += 0.9e-3;
      test::deliver(estimator, ImuReading{imu, {0, 0, 9.81}, {0, 0, 0}});
    }
  }
  const EstimatorStatus status = estimator.status();
  EXPECT_EQ(status.of(Source::kGps).waiting, StateEstimator::kMostWaiting);
  EXPECT_EQ(status.of(Source::kGps).refused, refused);
  EXPECT_EQ(status.of(Source::kGps).last_refusal, Outcome::kFull);
  EXPECT_GT(refused, 3000U);
}

TEST(InputsThatLag, WaitingAllocatesNothing) {
  const SimulatedVehicle vehicle(50, drive());
  const std::vector<Message> messages =
      delayed<ImuReading>(thinned<ImuReading>(vehicle.messages(), 0.27, 3, 50), 1.5);
  StateEstimator estimator(robot());
  const pipescout::test::HeapGuard guard;
  for (const Message& message : messages) {
    test::deliver(estimator, message.content);
  }
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_GT(estimator.updates(), 700U);
}

}  // namespace
}  // namespace pipescout::estimation
