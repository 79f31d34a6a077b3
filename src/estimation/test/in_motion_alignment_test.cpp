// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/in_motion_alignment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "pipescout/estimation/start_alignment.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SO3;
using Verdict = InMotionAlignment::Verdict;

constexpr double kGravity = 9.81;
constexpr double kImuPeriod = 0.01;         // s
constexpr int kSamplesPerPosition = 20;     // of the IMU: 5 Hz
constexpr double kPositionNoise = 0.02;     // m
const Vector3d kLeverArm(0.1, -0.05, 0.2);  // m

ImuIntegration integration() {
  ImuIntegration how;
  how.noise = {.gyro = 2e-4,
               .accelerometer = 1e-3,
               .gyro_bias = 1e-6,
               .accelerometer_bias = 1e-5,
               .integration = 1e-6};
  how.coasting = how.noise;
  how.max_held = 0.03;
  how.gravity = kGravity;
  return how;
}

/// A body that flies as `acceleration` (m/s^2, in the map) and `rate` (rad/s, in the body) say,
/// with a draw of what an alignment does not know.
class Flight {
 public:
  Vector3d wobble = Vector3d(0.5, 0.4, 0.2);  // m/s^2, of the acceleration
  double turning = 0.1;                       // rad/s

  Flight(std::uint64_t seed, double speed, double bias = 0.005) : engine_(seed) {
    truth.R_map_body = SO3::about_z(angle()) * SO3::exp(0.05 * normals());
    truth.position = Vector3d(1e4, -300, 80);
    truth.velocity = speed * normals();
    truth.gyro_bias = bias * normals();
    truth.accelerometer_bias = 0.03 * normals();
  }

  /// What the levelling of this body says.
  [[nodiscard]] StartHypothesis levelled() {
    StartHypothesis start;
    const Vector3d off = 0.05 * normals();
    start.mean.R_map_body = *level(truth.R_map_body.inverse() * (Vector3d(0, 0, kGravity) + off) +
                                   truth.accelerometer_bias);
    start.tilt_deviation = 0.02;
    start.gyro_bias_deviation = 0.005;
    return start;
  }

  ImuSample step() {
    const Vector3d acceleration =
        wobble.cwiseProduct(Vector3d(std::sin(0.9 * time), std::cos(1.3 * time), std::sin(time)));
    const Vector3d rate(0.1 * turning * std::cos(time), 0.1 * turning * std::sin(2 * time),
                        turning * std::sin(0.5 * time));
    const SO3 middle = truth.R_map_body * SO3::exp(0.5 * kImuPeriod * rate);
    const ImuNoise& noise = integration().noise;
    const double white = 1 / std::sqrt(kImuPeriod);
    const ImuSample sample = {
        .time = time,
        .duration = kImuPeriod,
        .angular_rate = rate + truth.gyro_bias + noise.gyro * white * normals(),
        .specific_force = middle.inverse() * (acceleration + Vector3d(0, 0, kGravity)) +
                          truth.accelerometer_bias + noise.accelerometer * white * normals()};
    truth.position += kImuPeriod * (truth.velocity + 0.5 * kImuPeriod * acceleration);
    truth.velocity += kImuPeriod * acceleration;
    truth.R_map_body = truth.R_map_body * SO3::exp(kImuPeriod * rate);
    time += kImuPeriod;
    return sample;
  }

  [[nodiscard]] GpsMeasurement position() {
    return {.time = time,
            .position = truth.position + truth.R_map_body * kLeverArm + kPositionNoise * normals(),
            .covariance = kPositionNoise * kPositionNoise * Eigen::Matrix3d::Identity()};
  }

  void fly(InMotionAlignment& alignment, double duration,
           const std::optional<InMotionAlignment::Standstill>& standstill = std::nullopt) {
    const auto positions = static_cast<int>(duration / (kImuPeriod * kSamplesPerPosition));
    for (int i = 0; i < positions; ++i) {
      for (int k = 0; k < kSamplesPerPosition; ++k) {
        alignment.add(step());
      }
      EXPECT_EQ(alignment.add(position(), kLeverArm, standstill), Verdict::kUsed);
    }
  }

  Vector3d normals() {
    std::normal_distribution<double> normal;
    return {normal(engine_), normal(engine_), normal(engine_)};
  }

  NavState truth{};
  double time = 100;

 private:
  double angle() {
    return std::uniform_real_distribution<double>(-std::numbers::pi, std::numbers::pi)(engine_);
  }

  std::mt19937_64 engine_;
};

InMotionAlignment begun(Flight& flight) {
  InMotionAlignment alignment(integration(), 1000);
  const StartHypothesis start = flight.levelled();
  alignment.begin(flight.time, &start, 1);
  return alignment;
}

TEST(InMotionAlignment, FindsTheWholeStateAndHowWellItIsKnown) {
  constexpr int kFlights = 40;
  double nees = 0;
  for (int seed = 1; seed <= kFlights; ++seed) {
    Flight flight(static_cast<std::uint64_t>(seed), 1);
    InMotionAlignment alignment = begun(flight);
    flight.fly(alignment, 20);
    const auto found = alignment.solve(flight.time, std::nullopt);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->positions, 100U);
    EXPECT_LT(found->heading_deviation, 0.05);
    const StateVector error = flight.truth.local(found->state);
    EXPECT_LT(error.segment<3>(kRotation).norm(), 0.1);
    nees += error.dot(found->covariance.ldlt().solve(error)) / kFlights;
  }
  // Of 15, whose mean over so many is within 4 standard deviations.
  EXPECT_NEAR(nees, kStateSize, 4 * std::sqrt(2.0 * kStateSize / kFlights));
}

TEST(InMotionAlignment, OnAStraightFlightItKnowsThatItDoesNotKnow) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Flight flight(seed, 1);
    flight.wobble.setZero();
    flight.turning = 0;
    InMotionAlignment alignment = begun(flight);
    flight.fly(alignment, 30);
    const auto found = alignment.solve(flight.time, std::nullopt);
    ASSERT_TRUE(found);
    EXPECT_GT(found->heading_deviation, 0.5);
    EXPECT_LT((found->state.velocity - flight.truth.velocity).norm(), 0.1);
    // Something else knows the heading.
    const double heading = flight.truth.R_map_body.roll_pitch_yaw().z();
    const auto told = alignment.solve(flight.time, InMotionAlignment::Heading{heading, 0.02});
    ASSERT_TRUE(told);
    EXPECT_LT(told->heading_deviation, 0.021);
    EXPECT_LT(flight.truth.local(told->state).segment<3>(kRotation).norm(), 0.05);
  }
}

TEST(InMotionAlignment, WhatSeemsToStandMayFly) {
  std::vector<double> deviations;  // m/s
  for (const double speed : {0.0, 0.5}) {
    Flight flight(7, speed, 0.001);
    flight.wobble.setZero();
    flight.turning = 0;
    StartHypothesis stands = flight.levelled();
    stands.mean.gyro_bias = flight.truth.gyro_bias;
    stands.gyro_bias_deviation = 1e-3;
    stands.velocity_deviation = 0.05;
    stands.stands = true;
    StartHypothesis flies = stands;
    flies.velocity_deviation = 1;
    flies.gyro_bias_deviation = 0.005;
    flies.stands = false;
    const std::array<StartHypothesis, 2> either = {stands, flies};
    InMotionAlignment alignment(integration(), 1000);
    alignment.begin(flight.time, either.data(), either.size());
    flight.fly(alignment, 4, InMotionAlignment::Standstill{0.01, flight.truth.gyro_bias, 2e-3});
    const auto found = alignment.solve(flight.time, std::nullopt);
    ASSERT_TRUE(found);
    const double off = (found->state.velocity - flight.truth.velocity).norm();
    EXPECT_LT(off, speed > 0 ? 0.1 : 0.01);
    deviations.push_back(std::sqrt(found->covariance(kVelocity, kVelocity)));
  }
  EXPECT_LT(deviations[0], deviations[1]);
}

TEST(InMotionAlignment, AWrongPositionIsRefusedAndManyContradict) {
  Flight flight(3, 1);
  InMotionAlignment alignment = begun(flight);
  flight.fly(alignment, 10);
  const auto next = [&](const Vector3d& off) {
    for (int k = 0; k < kSamplesPerPosition; ++k) {
      alignment.add(flight.step());
    }
    GpsMeasurement m = flight.position();
    m.position += off;
    return alignment.add(m, kLeverArm, std::nullopt);
  };
  EXPECT_EQ(next({30, 0, 0}), Verdict::kGated);
  EXPECT_EQ(next({0, 0, 0}), Verdict::kUsed);
  EXPECT_EQ(alignment.add(flight.position(), kLeverArm, std::nullopt), Verdict::kLate);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(next({-5, 3, 0}), Verdict::kGated);
  }
  EXPECT_EQ(next({-5, 3, 0}), Verdict::kContradicts);
}

TEST(InMotionAlignment, NothingBeforeTheFirstPosition) {
  Flight flight(4, 1);
  InMotionAlignment alignment(integration(), 1000);
  EXPECT_FALSE(alignment.begun());
  EXPECT_EQ(alignment.add(flight.position(), kLeverArm, std::nullopt), Verdict::kLate);
  const StartHypothesis start = flight.levelled();
  alignment.begin(flight.time, &start, 1);
  EXPECT_TRUE(alignment.begun());
  EXPECT_FALSE(alignment.solve(flight.time, std::nullopt));
  flight.fly(alignment, 0.2);
  EXPECT_TRUE(alignment.solve(flight.time, std::nullopt));
  alignment.end();
  EXPECT_FALSE(alignment.solve(flight.time, std::nullopt));
}

}  // namespace
}  // namespace pipescout::estimation
