// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/paper_bench.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "pipescout/odometry/odometer_stream.hpp"
#include "pipescout/simulation/crawler.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::odometry_study {
namespace {

using statistics::uniform;

using simulation::WheelFault;

constexpr std::array kSigmas{0.06, 0.055, 0.056};  // m a joint
constexpr double kSpeed = 0.3;                     // m/s
constexpr double kWrongShare = 0.1;                // of the readings
constexpr double kSlipRatio = 0.3;
constexpr double kLeastWrong = 0.2;  // m
constexpr double kMostWrong = kSlipRatio * kBenchJoint;
constexpr double kLength = kBenchJoints * kBenchJoint;

WheelFault draw_slip(std::size_t wheel, double joint_begin, std::mt19937_64& engine) {
  const double wrong = kLeastWrong + (kMostWrong - kLeastWrong) * uniform(engine);
  const double shortest = std::max(1.0, wrong / kSlipRatio);
  const double length =
      std::min(kBenchJoint, shortest + (kBenchJoint - shortest) * uniform(engine));
  const double begin = joint_begin + (kBenchJoint - length) * uniform(engine);
  return {.wheel = wheel, .begin = begin, .length = length, .ratio = wrong / length};
}

std::vector<WheelFault> draw_slips(BenchSlips slips, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  constexpr auto kWheels = static_cast<double>(kSigmas.size());
  std::vector<WheelFault> drawn;
  for (int joint = 0; joint < kBenchJoints; ++joint) {
    const double begin = kBenchJoint * joint;
    if (slips == BenchSlips::kOneAtATime && uniform(engine) < kWheels * kWrongShare) {
      drawn.push_back(
          draw_slip(static_cast<std::size_t>(kWheels * uniform(engine)), begin, engine));
    }
    for (std::size_t wheel = 0; wheel < kSigmas.size(); ++wheel) {
      if (slips == BenchSlips::kIndependent && uniform(engine) < kWrongShare) {
        drawn.push_back(draw_slip(wheel, begin, engine));
      }
    }
  }
  return drawn;
}

}  // namespace

BenchError run_paper_bench(BenchSlips slips, std::uint64_t seed) {
  odometry::OdometerStreamParameters parameters;
  simulation::CrawlerParameters wheels;
  for (const double sigma : kSigmas) {
    const double noise = sigma / std::sqrt(kBenchJoint);
    wheels.wheels.push_back({.noise_per_sqrt_metre = noise});
    parameters.odometers.push_back(
        {.resolution = wheels.wheels.back().resolution, .sigma_per_sqrt_metre = noise});
  }
  odometry::OdometerStream stream(parameters);
  const simulation::JointedPipe pipe({.joints = kBenchJoints,
                                      .joint_length = kBenchJoint,
                                      .length_spread = 0.0,
                                      .bend_share = 0.0,
                                      .slope_share = 0.0},
                                     seed);
  constexpr double kAtOnce = 1e3;  // m/s^2
  const simulation::Motion motion({{.speed = kSpeed, .duration = kLength / kSpeed}}, kAtOnce);
  simulation::Crawler crawler(pipe, motion, wheels, seed, draw_slips(slips, seed));
  BenchError result;
  while (const auto sample = crawler.next()) {
    if (stream.push({.odometer = sample->wheel, .time = sample->time, .value = sample->value})
            .ticks == 0) {
      continue;
    }
    const auto& state = stream.state();
    const double gone = motion.distance(state.time);
    const double error = state.distance - gone;
    constexpr double kTenJoints = 10.0 * kBenchJoint;
    if (gone <= kTenJoints) {
      result.percent_at_ten_joints = 100.0 * std::abs(error) / kTenJoints;
    }
    result.percent = 100.0 * std::abs(error) / kLength;
    result.sigmas = error / std::sqrt(state.variance);
  }
  return result;
}

}  // namespace pipescout::odometry_study
