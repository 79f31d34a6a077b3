// SPDX-License-Identifier: Apache-2.0
#include "pipescout/crawler_simulation/simulated_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <pipescout/simulation/uav.hpp>
#include <stdexcept>
#include <vector>

namespace pipescout {
namespace {

Tally tally(std::size_t joints) {
  Tally result;
  for (std::size_t i = 0; i <= joints; ++i) {
    result.ids.push_back(std::to_string(i));
    result.chainages.push_back(50.0 + 12.0 * static_cast<double>(i));
    result.variances.push_back(0.0);
    if (i < joints) {
      result.joints.push_back({.length = 12.0});
    }
  }
  return result;
}

/// Nothing disturbs: what is shown is what is.
SimulatedRunParameters undisturbed() {
  SimulatedRunParameters parameters;
  parameters.pipe.tally_sigma = 0.0;
  parameters.signal = simulation::undisturbed();
  parameters.crawler.wheels.resize(2);
  parameters.crawler.wheels[1].period = 0.05;
  parameters.features.valves_per_km = 0.0;
  parameters.features.bends_per_km = 0.0;
  parameters.features.dents_per_km = 0.0;
  parameters.start_joint = 3;
  parameters.motion.length = 30.0;
  return parameters;
}

TEST(SimulatedRun, ShowsWhereTheCrawlerIs) {
  SimulatedRun run(undisturbed(), tally(10));
  EXPECT_EQ(run.position(0.0).joint, 3U);
  EXPECT_NEAR(run.position(run.duration()).distance, 30.0, 1e-6);
  for (double time = 0.5; time <= run.duration(); time += 0.5) {
    const auto position = run.position(time);
    EXPECT_NEAR(position.chainage, 86.0 + position.distance, 1e-9);
    EXPECT_NEAR(position.into_joint, std::fmod(position.distance, 12.0), 1e-9);
    for (const auto& readings : run.readings_until(time)) {
      ASSERT_EQ(readings.wheels.size(), readings.values.size());
      const double truth = run.position(readings.time).distance;
      for (const double value : readings.values) {
        EXPECT_NEAR(value, truth, 0.001 + 1e-9);  // a step of the encoder
      }
    }
  }
}

TEST(SimulatedRun, WheelsGoTheirOwnWaysInBends) {
  constexpr double kPi = 3.14159265358979323846;
  constexpr double kRadius = 0.5;  // m
  SimulatedRunParameters parameters = undisturbed();
  parameters.crawler.wheels.assign(3, {});
  for (std::size_t i = 0; i < 3; ++i) {
    parameters.crawler.wheels[i].clock = 2.0 * kPi * static_cast<double>(i) / 3.0;
  }
  parameters.pipe_radius = kRadius;
  // The crawler starts at chainage 86 m: 10 m further there is a bend upwards by 90 degrees.
  parameters.route = {simulation::RoutePiece::straight(96.0),
                      simulation::RoutePiece::slope_bend(3.0, kPi / 2.0),
                      simulation::RoutePiece::straight(100.0)};
  SimulatedRun run(parameters, tally(10));
  const auto readings = run.readings_until(run.duration());
  const auto& last = readings.back();
  ASSERT_EQ(last.values.size(), 3U);
  const double truth = run.position(last.time).distance;
  // The wheel on top is on the inner side.
  EXPECT_NEAR(last.values[0], truth - kRadius * kPi / 2.0, 0.002);
  EXPECT_NEAR(last.values[1], truth + 0.5 * kRadius * kPi / 2.0, 0.002);
  EXPECT_NEAR(last.values[2], truth + 0.5 * kRadius * kPi / 2.0, 0.002);
  parameters.route[1] = simulation::RoutePiece::bend(3.0, kPi / 2.0);  // to the left
  SimulatedRun left(parameters, tally(10));
  const auto level = left.readings_until(left.duration()).back();
  EXPECT_GT(level.values[1], level.values[2] + kRadius);
  parameters.route[1] = simulation::RoutePiece::bend(0.4, kPi / 2.0);
  parameters.pipe_radius = -1.0;
  EXPECT_THROW(SimulatedRun(parameters, tally(10)), std::invalid_argument);
}

TEST(SimulatedRun, SamplesEvenlyAndSeesTheWeldWhereItIs) {
  SimulatedRun run(undisturbed(), tally(10));
  double largest = 0.0;
  double at = 0.0;
  std::size_t samples = 0;
  for (double time = 0.0; time <= run.duration(); time += 0.05) {
    const double first = run.next_sample_time();
    EXPECT_NEAR(first, static_cast<double>(samples) * run.sample_interval(), 1e-9);
    const auto values = run.samples_until(time);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double distance =
          run.position(first + static_cast<double>(k) * run.sample_interval()).distance;
      if (distance > 6.0 && distance < 18.0 && std::abs(values[k]) > largest) {
        largest = std::abs(values[k]);
        at = distance;
      }
    }
    samples += values.size();
  }
  EXPECT_GT(largest, 0.5);
  EXPECT_NEAR(at, 12.0, 0.03);  // one of the lobes of the weld at 12 m
}

TEST(SimulatedRun, IsTheSameForTheSameSeed) {
  SimulatedRunParameters parameters;
  parameters.crawler.wheels.resize(3);
  parameters.crawler.slip_spacing = 10.0;
  parameters.motion.length = 20.0;
  SimulatedRun a(parameters, tally(4));
  SimulatedRun b(parameters, tally(4));
  parameters.seed = 2;
  SimulatedRun c(parameters, tally(4));
  const auto x = a.samples_until(10.0);
  const auto y = b.samples_until(10.0);
  const auto z = c.samples_until(10.0);
  ASSERT_EQ(x.size(), y.size());
  bool differs = false;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const bool both_nan = std::isnan(x[k].real()) && std::isnan(y[k].real());
    EXPECT_TRUE(both_nan || x[k] == y[k]);
    differs |= x[k] != z[k];
  }
  EXPECT_TRUE(differs);
}

TEST(SimulatedRun, RefusesWhatMakesNoSense) {
  SimulatedRunParameters parameters = undisturbed();
  parameters.start_joint = 10;
  EXPECT_THROW(SimulatedRun(parameters, tally(10)), std::invalid_argument);
  parameters = undisturbed();
  parameters.motion.speed = -1.0;
  EXPECT_THROW(SimulatedRun(parameters, tally(10)), std::invalid_argument);
  parameters = undisturbed();
  parameters.crawler.wheels.clear();
  EXPECT_THROW(SimulatedRun(parameters, tally(10)), std::invalid_argument);
}

/// A perfect IMU, summed up, tells where the crawler is: standing first, then through a bend.
TEST(SimulatedRun, ItsImuIsThatOfItsMotion) {
  SimulatedRunParameters parameters = undisturbed();
  parameters.start_joint = 0;
  parameters.route = {simulation::RoutePiece::straight(55.0),
                      simulation::RoutePiece::bend(6.0, M_PI_2),
                      simulation::RoutePiece::straight(100.0)};
  parameters.imu.emplace();
  parameters.imu->period = 0.001;
  SimulatedRun run(parameters, tally(10));
  simulation::BodyMotion reckoned = run.body_motion(-1.0);
  EXPECT_EQ(reckoned.velocity, Eigen::Vector3d::Zero());
  EXPECT_NEAR(reckoned.T_map_body.translation().x(), 50.0, 1e-9);
  geometry::SO3 rotation = reckoned.T_map_body.rotation();
  Eigen::Vector3d position = reckoned.T_map_body.translation();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  const Eigen::Vector3d gravity(0, 0, simulation::kGravity);
  double time = -1.0;
  EXPECT_TRUE(run.imu_samples_until(-1.0).size() == 1);
  for (const double until : {0.0, 10.0, run.duration()}) {
    for (const auto& sample : run.imu_samples_until(until)) {
      const double dt = sample.time - time;
      time = sample.time;
      rotation = rotation * geometry::SO3::exp(dt * sample.reading.angular_rate);
      velocity += dt * (rotation * sample.reading.specific_force - gravity);
      position += dt * velocity;
    }
    const simulation::BodyMotion truth = run.body_motion(time);
    EXPECT_LT((position - truth.T_map_body.translation()).norm(), 0.02) << until;
    EXPECT_LT((rotation.inverse() * truth.T_map_body.rotation()).log().norm(), 1e-3) << until;
  }
  EXPECT_GT(position.y(), 5.0);  // it has gone round the bend
}

}  // namespace
}  // namespace pipescout
