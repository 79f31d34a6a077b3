// SPDX-License-Identifier: Apache-2.0
#include "odometry_inputs.hpp"

#include <cmath>
#include <random>

#include "pipescout/simulation/crawler.hpp"
#include "pipescout/simulation/eddy_current_signal.hpp"

namespace pipescout::benchmarks {
namespace {

constexpr std::uint64_t kSeed = 1001;
constexpr double kSpeed = 0.3;  // m/s

std::vector<odometry::WeldPosition> run_over(const simulation::JointedPipe& pipe, double scale,
                                             std::mt19937_64& engine) {
  constexpr double kSigma = 0.03;  // m, of one weld
  constexpr double kNoise = 0.01;  // m per square root of a metre
  constexpr double kSeenProbability = 0.98;
  std::normal_distribution<double> normal;
  std::bernoulli_distribution seen(kSeenProbability);
  std::vector<odometry::WeldPosition> welds;
  double chainage = 0.0;
  for (const auto& joint : pipe.joints()) {
    if (seen(engine)) {
      welds.push_back(
          {.chainage = chainage + kSigma * normal(engine), .standard_deviation = kSigma});
    }
    chainage += scale * joint.length + kNoise * std::sqrt(joint.length) * normal(engine);
  }
  return welds;
}

}  // namespace

WheelInput wheel_input(std::size_t wheels) {
  constexpr double kDistance = 60.0;  // m
  constexpr double kPeriod = 0.02;    // s
  WheelInput input;
  simulation::CrawlerParameters parameters{.slip_spacing = 30.0};
  input.parameters.tick_period = kPeriod;
  for (std::size_t i = 0; i < wheels; ++i) {
    parameters.wheels.push_back({.period = kPeriod,
                                 .start = 0.001 * static_cast<double>(i),
                                 .noise_per_sqrt_metre = 0.004});
    input.parameters.odometers.push_back({.sigma_per_sqrt_metre = 0.004});
  }
  simulation::Crawler crawler(
      simulation::JointedPipe({.joints = 10}, kSeed),
      simulation::Motion({{.speed = kSpeed, .duration = kDistance / kSpeed}}, 1.0), parameters,
      kSeed);
  while (const auto sample = crawler.next()) {
    input.samples.push_back(
        {.odometer = sample->wheel, .time = sample->time, .value = sample->value});
  }
  return input;
}

std::vector<SignalSample> signal_input() {
  constexpr double kDistance = 300.0;  // m
  const simulation::EddyCurrentParameters parameters;
  simulation::EddyCurrentSignal signal(
      parameters, simulation::draw_features({.length = kDistance}, kSeed), kSeed + 1);
  std::vector<SignalSample> samples;
  for (double at = 0.0; at < kDistance; at += kSpeed / parameters.sample_rate) {
    const auto sample = signal.next(at);
    if (sample.fault != simulation::SampleFault::kMissing) {
      samples.push_back({at, {sample.value.real(), sample.value.imag()}});
    }
  }
  return samples;
}

WeldLists weld_lists() {
  const simulation::JointedPipe pipe({.joints = 1600}, kSeed);
  std::mt19937_64 engine(kSeed);
  WeldLists lists;
  lists.then = run_over(pipe, 1.0, engine);
  lists.later = run_over(pipe, 1.003, engine);
  return lists;
}

}  // namespace pipescout::benchmarks
