// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/imu_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "pipescout/simulation/allan_deviation.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;

/// Of chi-square with that many degrees of freedom, at `deviations` of a normal variable (Wilson
/// and Hilferty).
double chi_square_at(double deviations, double degrees) {
  const double a = 2 / (9 * degrees);
  return degrees * std::pow(1 - a + deviations * std::sqrt(a), 3);
}

/// Six axes at rest, gyro first; of the accelerometer without gravity.
std::vector<std::vector<double>> record(const ImuParameters& parameters, std::size_t count,
                                        std::uint64_t seed) {
  ImuSensor sensor(parameters, seed);
  std::vector<std::vector<double>> axes(6);
  for (std::size_t i = 0; i < count; ++i) {
    const ImuReading reading = sensor.measure({});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      axes[axis].push_back(reading.angular_rate[static_cast<Eigen::Index>(axis)]);
      axes[axis + 3].push_back(reading.specific_force[static_cast<Eigen::Index>(axis)]);
    }
  }
  return axes;
}

/// Every axis has this deviation within what the estimator itself allows, 4 deviations wide.
void expect_deviation(const std::vector<std::vector<double>>& axes, std::size_t cluster,
                      double expected, AllanNoise noise) {
  for (const auto& samples : axes) {
    const double deviation = allan_deviation(samples, cluster);
    const double degrees = allan_degrees_of_freedom(noise, samples.size(), cluster);
    const double chi_square = degrees * deviation * deviation / (expected * expected);
    EXPECT_GT(chi_square, chi_square_at(-4, degrees)) << cluster;
    EXPECT_LT(chi_square, chi_square_at(4, degrees)) << cluster;
  }
}

/// Of the sensor's flicker noise, of floor 1: Allan variances of Gauss-Markov processes of variance
/// 1 and time constant T (IEEE 952, C.1.4), summed.
double flicker_deviation(double time) {
  double variance = 0;
  double constant = 1.0 / 16;
  for (std::size_t i = 0; i < ImuSensor::kFlickerProcesses; ++i) {
    const double x = time / constant;
    variance += 2 / x * (1 - (3 - 4 * std::exp(-x) + std::exp(-2 * x)) / (2 * x));
    constant *= 4;
  }
  return std::sqrt(variance);
}

/// At rest, rounding errors included, which are white.
double deviation_of(const InertialTriadParameters& triad, double period, double time) {
  const double rounding = triad.resolution * std::sqrt(period / 12);
  return std::hypot(std::hypot(triad.noise_density, rounding) / std::sqrt(time),
                    triad.bias_instability * flicker_deviation(time));
}

TEST(AllanDeviation, OfAFewSamplesByHand) {
  const std::vector<double> samples{1, 3, 2, 6};
  // Differences 2, -1, 4.
  EXPECT_NEAR(allan_deviation(samples, 1), std::sqrt((4 + 1 + 16) / 6.0), 1e-15);
  EXPECT_NEAR(allan_deviation(samples, 2), std::sqrt(4 / 2.0), 1e-15);
  EXPECT_THROW((void)allan_deviation(samples, 0), std::invalid_argument);
  EXPECT_THROW((void)allan_deviation(samples, 3), std::invalid_argument);
}

TEST(AllanDeviation, ARampRises) {
  std::vector<double> samples;
  for (int i = 0; i < 1000; ++i) {
    samples.push_back(0.01 * i);
  }
  for (const std::size_t cluster : {1U, 7U, 300U}) {
    EXPECT_NEAR(allan_deviation(samples, cluster),
                0.01 * static_cast<double>(cluster) / std::numbers::sqrt2, 1e-9);
  }
}

TEST(ImuSensor, WhiteNoiseHasSlopeMinusOneHalf) {
  ImuParameters parameters;
  parameters.period = 0.01;
  parameters.gyro.noise_density = 1e-3;
  parameters.accelerometer.noise_density = 1e-3;
  const auto axes = record(parameters, 200'000, 1);
  for (const std::size_t cluster : {1U, 10U, 100U, 1000U, 10'000U}) {
    const double time = 0.01 * static_cast<double>(cluster);
    expect_deviation(axes, cluster, 1e-3 / std::sqrt(time), AllanNoise::kWhite);
  }
}

TEST(ImuSensor, BiasInstabilityIsFlat) {
  ImuParameters parameters;
  parameters.period = 0.02;  // below the quickest time constant
  parameters.gyro.bias_instability = 1e-4;
  parameters.accelerometer.bias_instability = 1e-4;
  const auto axes = record(parameters, 200'000, 2);
  for (const std::size_t cluster : {100U, 400U, 1600U, 6400U, 25'600U}) {  // 2 s to 512 s
    const double time = 0.02 * static_cast<double>(cluster);
    expect_deviation(axes, cluster, 1e-4 * flicker_deviation(time), AllanNoise::kFlicker);
    EXPECT_NEAR(flicker_deviation(time), 1, 0.03);
  }
}

TEST(ImuSensor, BiasInstabilityIsAsDeepAsItsParameter) {
  for (double time = 1; time < 1000; time *= 1.3) {
    EXPECT_NEAR(flicker_deviation(time), 1, 0.03) << time;
  }
}

TEST(ImuSensor, BiasRandomWalkHasSlopeOneHalf) {
  ImuParameters parameters;
  parameters.period = 0.1;
  parameters.gyro.bias_random_walk = 1e-5;
  parameters.accelerometer.bias_random_walk = 1e-5;
  const auto axes = record(parameters, 200'000, 3);
  for (const std::size_t cluster : {10U, 100U, 1000U, 5000U}) {
    const double time = 0.1 * static_cast<double>(cluster);
    expect_deviation(axes, cluster, 1e-5 * std::sqrt(time / 3), AllanNoise::kRandomWalk);
  }
}

TEST(ImuSensor, PresetsHaveTheFiguresOfTheirDataSheets) {
  for (ImuParameters parameters :
       {ImuParameters::tactical(), ImuParameters::industrial(), ImuParameters::consumer()}) {
    EXPECT_NO_THROW(parameters.validate());
    parameters.period = 0.05;
    const auto axes = record(parameters, 100'000, 4);
    const std::vector<std::vector<double>> gyro(axes.begin(), axes.begin() + 3);
    const std::vector<std::vector<double>> accelerometer(axes.begin() + 3, axes.end());
    for (const std::size_t cluster : {10U, 10'000U}) {  // white noise at 0.5 s, and both at 500 s
      const AllanNoise noise = cluster == 10 ? AllanNoise::kWhite : AllanNoise::kFlicker;
      const double time = 0.05 * static_cast<double>(cluster);
      expect_deviation(gyro, cluster, deviation_of(parameters.gyro, 0.05, time), noise);
      expect_deviation(accelerometer, cluster, deviation_of(parameters.accelerometer, 0.05, time),
                       noise);
    }
  }
}

TEST(ImuSensor, ConstantErrorsAreThoseOfADrawPerAxis) {
  ImuParameters parameters;
  parameters.gyro = {.turn_on_bias = 0.01, .scale_error = 0.02, .misalignment = 0.005};
  constexpr int kSensors = 400;
  double bias = 0;
  double scale = 0;
  double across = 0;
  for (int i = 0; i < kSensors; ++i) {
    ImuSensor sensor(parameters, static_cast<std::uint64_t>(i));
    const Vector3d at_rest = sensor.measure({}).angular_rate;
    EXPECT_EQ(sensor.biases().angular_rate, at_rest);
    const Vector3d turning = sensor.measure({.angular_rate = {0, 2, 0}}).angular_rate - at_rest;
    bias += at_rest.squaredNorm() / (3 * kSensors);
    scale += std::pow(turning.y() / 2 - 1, 2) / kSensors;
    across += (turning.x() * turning.x() + turning.z() * turning.z()) / 4 / (2 * kSensors);
  }
  const double spread = 4 * std::sqrt(2.0 / kSensors);
  EXPECT_NEAR(bias, 1e-4, 1e-4 * spread);
  EXPECT_NEAR(scale, 4e-4, 4e-4 * spread);
  EXPECT_NEAR(across, 2.5e-5, 2.5e-5 * spread);
}

TEST(ImuSensor, SaturatesAndRounds) {
  ImuParameters parameters;
  parameters.accelerometer = {.range = 20, .resolution = 0.5};
  ImuSensor sensor(parameters, 1);
  const Vector3d shown = sensor.measure({.specific_force = {3.3, -100, 9.8}}).specific_force;
  EXPECT_EQ(shown, Vector3d(3.5, -20, 10));
}

TEST(ImuSensor, TheSameSeedGivesTheSameBits) {
  const auto one = record(ImuParameters::consumer(), 100, 9);
  EXPECT_EQ(one, record(ImuParameters::consumer(), 100, 9));
  EXPECT_NE(one, record(ImuParameters::consumer(), 100, 10));
}

TEST(ImuSensor, RefusesNonsenseByName) {
  ImuParameters parameters;
  parameters.gyro.misalignment = 1;
  try {
    const ImuSensor sensor(parameters, 1);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "gyro.misalignment: 1 is outside [0, 0.2]");
  }
  parameters = {};
  parameters.accelerometer.range = 0;
  EXPECT_THROW(ImuSensor(parameters, 1), std::invalid_argument);
  parameters = {};
  parameters.period = NAN;
  EXPECT_THROW(ImuSensor(parameters, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
