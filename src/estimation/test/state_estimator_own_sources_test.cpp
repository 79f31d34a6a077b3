// SPDX-License-Identifier: Apache-2.0
// Sources beyond those that are watched: their factors go to the smoother as they are.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "heap_guard.hpp"
#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::SimulatedVehicle;
using test::VehicleOptions;

const Vector3d kSensor(0.2, -0.1, 0.5);  // m, in the body
constexpr double kBias = 40;             // m, of the barometer at the start
constexpr double kDrift = 0.005;         // m/s, of its bias
constexpr double kOutage = 30;           // s, GPS there before

enum : std::size_t { kBarometer, kVelocity, kBeacons, kWheelVelocity, kOwnSources };

/// A robot with GPS until `kOutage`, and all kinds of other sensors at 5 Hz.
class StateEstimatorOwnSourcesTest : public testing::Test {
 protected:
  static StateEstimatorParameters parameters() {
    StateEstimatorParameters p = StateEstimatorParameters::ground_robot();
    p.smoother.imu_noise = test::vehicle_imu_noise();
    p.own_sources.resize(kOwnSources);
    p.own_sources[kBarometer].correlation_time = 0.5;
    p.smoother.global_deviations.own[0] = 100;
    p.smoother.own_walks[0] = 0.05;
    return p;
  }
  [[nodiscard]] static VehicleOptions options() {
    VehicleOptions options;
    options.duration = 90;
    return options;
  }
  double draw(double scale) { return std::normal_distribution<double>(0, scale)(engine_); }

  Vector3d noise(double scale) { return {draw(scale), draw(scale), draw(scale)}; }

  void measure(StateEstimator& estimator, double time) {
    const NavState x = vehicle_.truth(time);
    const Vector3d place = x.position + x.R_map_body * kSensor;
    const auto add = [&](std::size_t source, const auto& m) {
      if (enabled_[source]) {
        estimator.add(AnyFactor(m, own_kind(source)));
      }
    };
    add(kBarometer,
        HeightMeasurement{time, place.z() + kBias + kDrift * time + draw(0.1), 0.1, kSensor, 0});
    // Of the origin: the angular rate is not known here.
    add(kVelocity, VelocityMeasurement{.time = time,
                                       .velocity = x.velocity + noise(0.05),
                                       .covariance = 0.0025 * Matrix3d::Identity()});
    add(kWheelVelocity,
        BodyVelocityMeasurement{.time = time,
                                .velocity = x.R_map_body.inverse() * x.velocity + noise(0.05),
                                .covariance = 0.0025 * Matrix3d::Identity()});
    for (const Vector3d& beacon :
         {Vector3d(120, -40, 25), Vector3d(90, -70, 30), Vector3d(80, -30, 22)}) {
      add(kBeacons,
          RangeMeasurement{time, (place - beacon).norm() + draw(0.2), 0.2, beacon, kSensor});
    }
  }
  void run(StateEstimator& estimator) {
    double next = 0;
    for (const test::Message& message : vehicle_.messages()) {
      for (; next < message.arrival; next += 0.2) {
        measure(estimator, next);
      }
      if (message.arrival > kOutage && std::holds_alternative<GpsMeasurement>(message.content)) {
        continue;
      }
      test::deliver(estimator, message.content);
    }
  }
  [[nodiscard]] Vector3d error(const StateEstimator& estimator) const {
    const auto estimate = estimator.estimate();
    EXPECT_TRUE(estimate && estimate->in_map);
    return estimate->state.position - vehicle_.truth(estimate->time).position;
  }

  std::mt19937 engine_{1};
  SimulatedVehicle vehicle_{3, options()};
  std::array<bool, kOwnSources> enabled_{};
};

TEST_F(StateEstimatorOwnSourcesTest, BeaconsHoldThePositionWithoutGps) {
  StateEstimator without(parameters());
  run(without);
  enabled_[kBeacons] = true;
  StateEstimator with(parameters());
  run(with);
  EXPECT_LT(error(with).head<2>().norm(), 0.2);
  EXPECT_LT(error(with).head<2>().norm(), error(without).head<2>().norm());
  const SourceStatus status = with.status().own_sources[kBeacons];
  EXPECT_EQ(status.state, SourceState::kTrusted);
  EXPECT_GT(status.accepted, 1000U);
  EXPECT_GT(status.held, 0U);  // until the state was in the map
  EXPECT_EQ(status.refused, 0U);
  EXPECT_LT(status.gated, 5U);
}

TEST_F(StateEstimatorOwnSourcesTest, ABarometerWhoseBiasWalksHoldsTheHeight) {
  enabled_[kBarometer] = true;
  StateEstimator estimator(parameters());
  run(estimator);
  const double bias = estimator.smoother().globals().own[0];
  const double deviation =
      std::sqrt(estimator.smoother().global_covariance()(kOwnStates, kOwnStates));
  const double truth = kBias + kDrift * options().duration;
  EXPECT_LT(std::abs(bias - truth), 3 * deviation);
  EXPECT_LT(deviation, 1);
  EXPECT_GT(estimator.status().own_sources[kBarometer].accepted, 300U);
}

TEST_F(StateEstimatorOwnSourcesTest, VelocitiesAreUsedWhereTheyAreDefined) {
  enabled_[kVelocity] = enabled_[kWheelVelocity] = true;
  StateEstimator estimator(parameters());
  run(estimator);
  const EstimatorStatus status = estimator.status();
  // In the body at once, in the map when the state is there.
  EXPECT_GT(status.own_sources[kVelocity].held, status.own_sources[kWheelVelocity].held);
  for (const std::size_t source : {std::size_t{kVelocity}, std::size_t{kWheelVelocity}}) {
    EXPECT_GT(status.own_sources[source].accepted, 300U);
    EXPECT_LT(status.own_sources[source].gated, 5U);
  }
  EXPECT_LT(error(estimator).norm(), 2);
}

TEST_F(StateEstimatorOwnSourcesTest, GrossErrorsAreGatedAndFaultsRefused) {
  enabled_[kBeacons] = true;
  StateEstimator estimator(parameters());
  run(estimator);
  const double now = estimator.estimate()->time;
  const Vector3d place = vehicle_.truth(now).position;
  const auto send = [&](RangeMeasurement m) {
    return estimator.add(AnyFactor(m, own_kind(kBeacons)));
  };
  EXPECT_EQ(send({now, std::nan(""), 0.2, Vector3d::Zero()}), Outcome::kNotFinite);
  EXPECT_EQ(send({now, 3, 0, Vector3d::Zero()}), Outcome::kBadCovariance);
  EXPECT_EQ(send({now - 50, 3, 0.2, Vector3d::Zero()}), Outcome::kLate);
  const SourceStatus before = estimator.status().own_sources[kBeacons];
  EXPECT_EQ(before.refused, 3U);
  EXPECT_EQ(before.last_refusal, Outcome::kLate);
  EXPECT_EQ(send({now - 0.15, place.norm() + 300, 0.2, Vector3d::Zero()}), Outcome::kWaiting);
  for (int i = 1; i <= 30; ++i) {
    const double time = now + 0.01 * i;
    estimator.add(ImuReading{time, Vector3d(0, 0, 9.81), Vector3d::Zero()});
  }
  EXPECT_EQ(estimator.status().own_sources[kBeacons].gated, before.gated + 1);
  // Of no source that the parameters name.
  EXPECT_EQ(estimator.add(AnyFactor(HeightMeasurement{now, 1, 1}, own_kind(kOwnSources))),
            Outcome::kUninitialised);
  EXPECT_EQ(estimator.add(AnyFactor(NonHolonomicMeasurement{now, 1, 1})), Outcome::kUninitialised);
}

TEST_F(StateEstimatorOwnSourcesTest, NothingIsAllocated) {
  enabled_.fill(true);
  StateEstimator estimator(parameters());
  const std::size_t messages = vehicle_.messages().size();
  ASSERT_GT(messages, 0U);
  const pipescout::test::HeapGuard guard;
  run(estimator);
  EXPECT_EQ(guard.allocations(), 0U);
}

TEST(StateEstimatorOwnSourcesParametersTest, AreValidated) {
  StateEstimatorParameters p;
  p.own_sources.resize(kOwnFactorKinds);
  EXPECT_NO_THROW(p.validate());
  p.own_sources[2].correlation_time = -1;
  EXPECT_THROW(p.validate(), std::invalid_argument);
  p.own_sources.clear();
  p.own_sources.resize(kOwnFactorKinds + 1);
  EXPECT_THROW(p.validate(), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::estimation
