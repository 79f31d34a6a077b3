// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/imu_sensor.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "pipescout/simulation/uav.hpp"
#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

constexpr double kShortest = 1.0 / 16;  // s, time constant of the quickest flicker process
constexpr double kApart = 4;            // of time constants
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kHour = 3600;  // s
constexpr double kMicroG = 1e-6 * kGravity;

Eigen::Vector3d white(std::mt19937_64& engine) {
  Eigen::Vector3d result;
  for (double& entry : result) {
    entry = statistics::normal(engine);
  }
  return result;
}

void check_triad(const std::string& name, const InertialTriadParameters& triad) {
  using validation::check_within;
  check_within(name + ".noise_density", triad.noise_density, 0, 10);
  check_within(name + ".bias_instability", triad.bias_instability, 0, 10);
  check_within(name + ".bias_random_walk", triad.bias_random_walk, 0, 10);
  check_within(name + ".turn_on_bias", triad.turn_on_bias, 0, 10);
  check_within(name + ".scale_error", triad.scale_error, 0, 0.2);
  check_within(name + ".misalignment", triad.misalignment, 0, 0.2);
  validation::check_above(name + ".range", triad.range, 0, 1e6);
  check_within(name + ".resolution", triad.resolution, 0, 10);
}

}  // namespace

void ImuParameters::validate() const {
  check_triad("gyro", gyro);
  check_triad("accelerometer", accelerometer);
  validation::check_within("period", period, 1e-4, 1);
}

ImuParameters ImuParameters::tactical() {
  return {.gyro = {.noise_density = 0.09 * kDegree / 60,
                   .bias_instability = 0.8 * kDegree / kHour,
                   .turn_on_bias = 0.07 * kDegree,
                   .scale_error = 0.002,
                   .misalignment = 0.05 * kDegree,
                   .range = 125 * kDegree,
                   .resolution = 0.00625 * kDegree / 65536},
          .accelerometer = {.noise_density = 0.008 / 60,
                            .bias_instability = 3.2 * kMicroG,
                            .turn_on_bias = 1400 * kMicroG,
                            .scale_error = 0.0005,
                            .misalignment = 0.035 * kDegree,
                            .range = 8 * kGravity,
                            .resolution = 250 * kMicroG / 65536}};
}

ImuParameters ImuParameters::industrial() {
  return {.gyro = {.noise_density = 0.008 * kDegree,
                   .bias_instability = 8 * kDegree / kHour,
                   .turn_on_bias = 0.2 * kDegree,
                   .scale_error = 0.003,
                   .misalignment = 0.05 * kDegree,
                   .range = 2000 * kDegree,
                   .resolution = 0.1 * kDegree / 65536},
          .accelerometer = {.noise_density = 0.037 / 60,
                            .bias_instability = 13 * kMicroG,
                            .turn_on_bias = 2000 * kMicroG,
                            .scale_error = 0.001,
                            .misalignment = 0.05 * kDegree,
                            .range = 40 * kGravity,
                            .resolution = 1250 * kMicroG / 65536}};
}

ImuParameters ImuParameters::consumer() {
  return {.gyro = {.noise_density = 0.014 * kDegree,
                   .bias_instability = 10 * kDegree / kHour,
                   .turn_on_bias = 1 * kDegree,
                   .scale_error = 0.01,
                   .misalignment = 0.01,
                   .range = 2000 * kDegree,
                   .resolution = 2000 * kDegree / 32768},
          .accelerometer = {.noise_density = 175 * kMicroG,
                            .bias_instability = 60 * kMicroG,
                            .turn_on_bias = 20'000 * kMicroG,
                            .scale_error = 0.005,
                            .misalignment = 0.005,
                            .range = 24 * kGravity,
                            .resolution = 24 * kGravity / 32768}};
}

Eigen::Vector3d ImuSensor::Triad::bias() const noexcept {
  Eigen::Vector3d sum = constant + walk;
  for (const Eigen::Vector3d& process : flicker) {
    sum += process;
  }
  return sum;
}

ImuParameters ImuParameters::of_grade(std::string_view grade) {
  if (grade == "tactical") {
    return tactical();
  }
  if (grade == "industrial") {
    return industrial();
  }
  if (grade == "consumer") {
    return consumer();
  }
  throw std::invalid_argument("grade of IMU '" + std::string(grade) +
                              "' is not one of 'tactical', 'industrial', 'consumer'");
}

ImuSensor::ImuSensor(const ImuParameters& parameters, std::uint64_t seed)
    : parameters_(parameters), engine_(statistics::make_engine(seed, 3)) {
  parameters_.validate();
  double time = kShortest;
  for (double& decay : decay_) {
    decay = std::exp(-parameters_.period / time);
    time *= kApart;
  }
  gyro_ = make(parameters_.gyro);
  accelerometer_ = make(parameters_.accelerometer);
}

ImuSensor::Triad ImuSensor::make(const InertialTriadParameters& parameters) {
  Triad triad;
  for (Eigen::Index row = 0; row < 3; ++row) {
    const double scale = 1 + parameters.scale_error * statistics::normal(engine_);
    for (Eigen::Index column = 0; column < 3; ++column) {
      triad.shown_by_true(row, column) =
          scale * (row == column ? 1.0 : parameters.misalignment * statistics::normal(engine_));
    }
  }
  triad.constant = parameters.turn_on_bias * white(engine_);
  for (Eigen::Vector3d& process : triad.flicker) {
    process = parameters.bias_instability * white(engine_);
  }
  return triad;
}

void ImuSensor::drift(const InertialTriadParameters& parameters, Triad& triad) {
  triad.walk += parameters.bias_random_walk * std::sqrt(parameters_.period) * white(engine_);
  for (std::size_t i = 0; i < kFlickerProcesses; ++i) {
    const double growth = parameters.bias_instability * std::sqrt(1 - decay_[i] * decay_[i]);
    triad.flicker[i] = decay_[i] * triad.flicker[i] + growth * white(engine_);
  }
}

Eigen::Vector3d ImuSensor::show(const InertialTriadParameters& parameters, const Triad& triad,
                                const Eigen::Vector3d& truth) {
  Eigen::Vector3d shown = triad.shown_by_true * truth + triad.bias() +
                          parameters.noise_density / std::sqrt(parameters_.period) * white(engine_);
  shown = shown.cwiseMax(-parameters.range).cwiseMin(parameters.range);
  if (parameters.resolution > 0) {
    shown = parameters.resolution * (shown / parameters.resolution).array().round();
  }
  return shown;
}

ImuReading ImuSensor::measure(const ImuReading& truth) {
  if (started_) {
    drift(parameters_.gyro, gyro_);
    drift(parameters_.accelerometer, accelerometer_);
  }
  started_ = true;
  return {.angular_rate = show(parameters_.gyro, gyro_, truth.angular_rate),
          .specific_force = show(parameters_.accelerometer, accelerometer_, truth.specific_force)};
}

ImuReading ImuSensor::biases() const noexcept {
  return {.angular_rate = gyro_.bias(), .specific_force = accelerometer_.bias()};
}

}  // namespace pipescout::simulation
