// SPDX-License-Identifier: Apache-2.0
// The set-up of Wang and others (2008), section 4, as a stream: a bench of a hundred metres of 5.5
// m joints, three odometers of sigma 0.06, 0.055 and 0.056 m a joint.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry {
namespace {

constexpr std::array<double, 3> kSigmas = {0.06, 0.055, 0.056};  // m a joint
constexpr double kJoint = 5.5;                                   // m
constexpr int kJoints = 18;
constexpr double kStep = 0.006;              // m between samples
constexpr double kSpeed = 0.3;               // m/s
constexpr double kWrongShare = 0.1;          // of the readings
constexpr double kLeastWrong = 0.2;          // m: 3.6 sigma
constexpr double kMostWrong = 0.3 * kJoint;  // m
constexpr double kResolution = 0.001;        // m

enum class Slips {
  kNone,
  kOneAtATime,   // a tenth of the readings wrong, never two of one joint
  kIndependent,  // each reading wrong with probability 0.1: two of three at once in 3 % of the
                 // joints
};

/// A reading of a joint is wrong because the wheel slips by up to 30 % on some stretch of it.
struct Slip {
  double begin = 0.0;  // m
  double end = 0.0;
  double ratio = 0.0;
};

Slip draw_slip(double joint_begin, std::mt19937_64& engine) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double wrong = kLeastWrong + (kMostWrong - kLeastWrong) * uniform(engine);
  const double shortest = std::max(1.0, wrong / 0.3);
  const double length = std::min(kJoint, shortest + (kJoint - shortest) * uniform(engine));
  const double begin = joint_begin + (kJoint - length) * uniform(engine);
  return {.begin = begin, .end = begin + length, .ratio = wrong / length};
}

std::array<Slip, 3> draw_slips(Slips slips, double joint_begin, std::mt19937_64& engine) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::array<Slip, 3> drawn{};
  if (slips == Slips::kOneAtATime && uniform(engine) < 3.0 * kWrongShare) {
    drawn[static_cast<std::size_t>(3.0 * uniform(engine))] = draw_slip(joint_begin, engine);
  }
  for (auto& each : drawn) {
    if (slips == Slips::kIndependent && uniform(engine) < kWrongShare) {
      each = draw_slip(joint_begin, engine);
    }
  }
  return drawn;
}

struct Run {
  double percent_at_ten_joints = 0.0;  // error in per cent of the distance
  double percent = 0.0;                // the same at the end of the bench
  double sigmas = 0.0;                 // error at the end in stated standard deviations
};

Run run(std::uint64_t seed, Slips slips) {
  OdometerStreamParameters parameters;
  for (const double sigma : kSigmas) {
    parameters.odometers.push_back(
        {.resolution = kResolution, .sigma_per_sqrt_metre = sigma / std::sqrt(kJoint)});
  }
  OdometerStream stream(parameters);
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::array<double, 3> shown{};
  std::array<Slip, 3> slip{};
  Run result;
  int joint = -1;
  const int steps = static_cast<int>(kJoints * kJoint / kStep);
  for (int k = 0; k <= steps; ++k) {
    const double position = kStep * k;
    if (position >= kJoint * (joint + 1)) {
      ++joint;
      slip = draw_slips(slips, kJoint * joint, engine);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      if (k > 0) {
        const bool slipping = position > slip[i].begin && position <= slip[i].end;
        shown[i] += kStep * (slipping ? 1.0 - slip[i].ratio : 1.0) +
                    kSigmas[i] * std::sqrt(kStep / kJoint) * normal(engine);
      }
      stream.push({.odometer = i,
                   .time = position / kSpeed,
                   .value = kResolution * std::floor(shown[i] / kResolution)});
    }
    const auto& state = stream.state();
    const double error = state.distance - kSpeed * state.time;
    if (kSpeed * state.time <= 10.0 * kJoint) {
      result.percent_at_ten_joints = 100.0 * std::abs(error) / (10.0 * kJoint);
    }
    result.percent = 100.0 * std::abs(error) / (kJoints * kJoint);
    result.sigmas = error / std::sqrt(state.variance);
  }
  return result;
}

struct Figures {
  double p95 = 0.0;
  double worst = 0.0;
  double p95_at_ten_joints = 0.0;
  double worst_at_ten_joints = 0.0;
  double rms_sigmas = 0.0;
};

Figures measure(std::uint64_t first_seed, std::uint64_t last_seed, Slips slips) {
  std::vector<double> percent;
  std::vector<double> at_ten;
  double squares = 0.0;
  for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed) {
    const Run each = run(seed, slips);
    percent.push_back(each.percent);
    at_ten.push_back(each.percent_at_ten_joints);
    squares += each.sigmas * each.sigmas / static_cast<double>(last_seed - first_seed + 1);
  }
  const auto p95 = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[(values.size() * 95 + 99) / 100 - 1];
  };
  return {.p95 = p95(percent),
          .worst = *std::max_element(percent.begin(), percent.end()),
          .p95_at_ten_joints = p95(at_ten),
          .worst_at_ten_joints = *std::max_element(at_ten.begin(), at_ten.end()),
          .rms_sigmas = std::sqrt(squares)};
}

void print(const char* what, const Figures& figures) {
  std::printf(
      "%s: p95 %.3f %%, worst %.3f %% of 99 m; p95 %.3f %%, worst %.3f %% of 55 m; "
      "rms error %.2f of the stated standard deviation\n",
      what, figures.p95, figures.worst, figures.p95_at_ten_joints, figures.worst_at_ten_joints,
      figures.rms_sigmas);
}

TEST(OdometerStreamPaper, WorstErrorBelowOnePerCentOfTheDistance) {
  const Figures unseen = measure(1001, 1020, Slips::kOneAtATime);  // seeds that no tuning saw
  print("one reading in ten wrong, seeds 1001 to 1020", unseen);
  EXPECT_LT(unseen.worst, 1.0);
  EXPECT_LT(unseen.p95, 0.4);
}

TEST(OdometerStreamPaper, WithoutSlipsConsensusCostsLittle) {
  const Figures sound = measure(1, 100, Slips::kNone);
  print("none wrong, seeds 1 to 100", sound);
  // The best that three such odometers allow: 0.0329 m a joint, 0.276 % at 95 %.
  EXPECT_LT(sound.p95, 1.25 * 0.276);
  EXPECT_NEAR(sound.rms_sigmas, 1.0, 0.2);
}

TEST(OdometerStreamPaper, TheStatedDeviationHoldsWithSlips) {
  const Figures figures = measure(1, 100, Slips::kOneAtATime);
  print("one reading in ten wrong, seeds 1 to 100", figures);
  EXPECT_NEAR(figures.rms_sigmas, 1.0, 0.35);
  EXPECT_LT(figures.worst, 1.0);
}

TEST(OdometerStreamPaper, TwoOfThreeSlippingAlikeAreBelieved) {
  // What no consensus can see, and weld spacing has to: this is why the distance is not the last
  // word on where the crawler is.
  const Figures figures = measure(1001, 1020, Slips::kIndependent);
  print("the same with two of three at once, seeds 1001 to 1020", figures);
  EXPECT_GT(figures.worst, 1.0);
}

}  // namespace
}  // namespace pipescout::odometry
