// SPDX-License-Identifier: Apache-2.0
// Scores the detector on the simulated signal with all its disturbances, on seeds that no tuning
// saw. The speed goes from 0.02 to 0.58 m/s, the crawler stands for 15 s every 200 s and turns back
// for 2 m every 900 s.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "pipescout/odometry/weld_detector.hpp"
#include "pipescout/simulation/eddy_current_signal.hpp"

namespace pipescout::odometry {
namespace {

using simulation::FeatureKind;
using simulation::SampleFault;

constexpr std::uint64_t kFirstSeed = 1001;  // tuned on 1 to 100
constexpr double kClose = 0.05;             // m; an event farther from any weld is false
constexpr double kEnds = 1.0;               // m, at either end of the pipe, not scored

struct Score {
  int welds = 0;
  int found = 0;
  int wrong = 0;
  double km = 0.0;
  std::vector<double> errors;      // m
  std::vector<double> normalised;  // by the stated standard deviation
  std::uint64_t samples = 0;
};

/// Distance over time, sample by sample.
class Drive {
 public:
  explicit Drive(double sample_rate) : step_(1.0 / sample_rate) {}
  double next() {
    time_ += step_;
    const double speed = 0.3 + 0.2 * std::sin(time_ / 37.0) + 0.08 * std::sin(time_ / 5.3);
    const bool stands = std::fmod(time_, 200.0) > 185.0;
    if (std::fmod(time_, 900.0) < step_) {
      back_ = 2.0;
    }
    if (!stands) {
      const double move = speed * step_;
      at_ += back_ > 0.0 ? -move : move;
      back_ -= move;
    }
    return at_;
  }

 private:
  double step_;
  double time_ = 0.0;
  double at_ = 0.0;
  double back_ = 0.0;
};

void judge(const std::vector<simulation::PipeFeature>& features,
           const std::vector<WeldEvent>& events, double length, Score& score) {
  std::vector<bool> used(events.size());
  for (const auto& feature : features) {
    if (feature.kind != FeatureKind::kWeld) {
      continue;
    }
    std::size_t best = events.size();
    for (std::size_t i = 0; i < events.size(); ++i) {
      const double off = std::abs(events[i].distance - feature.position);
      if (!used[i] && off < kClose &&
          (best == events.size() || off < std::abs(events[best].distance - feature.position))) {
        best = i;
      }
    }
    const bool found = best != events.size();
    if (found) {
      used[best] = true;
    }
    if (feature.position < kEnds || feature.position > length - kEnds) {
      continue;
    }
    ++score.welds;
    if (found) {
      ++score.found;
      const double error = std::abs(events[best].distance - feature.position);
      score.errors.push_back(error);
      score.normalised.push_back(error / events[best].standard_deviation);
    }
  }
  score.wrong += static_cast<int>(std::count(used.begin(), used.end(), false));
}

Score run(double snr, int seeds, double length) {
  Score score;
  for (int i = 0; i < seeds; ++i) {
    const std::uint64_t seed = kFirstSeed + static_cast<std::uint64_t>(i);
    const auto features = simulation::draw_features({.length = length}, seed);
    const simulation::EddyCurrentParameters signal_parameters{.peak_snr = snr};
    simulation::EddyCurrentSignal signal(signal_parameters, features, seed + 1000000);
    WeldDetector detector({});
    Drive drive(signal_parameters.sample_rate);
    std::vector<WeldEvent> events;
    for (double at = 0.0; at < length; at = drive.next()) {
      const auto sample = signal.next(at);
      if (sample.fault != SampleFault::kMissing) {
        const Impedance value{sample.value.real(), sample.value.imag()};
        const auto found = detector.update(at, {&value, 1});
        events.insert(events.end(), found.begin(), found.end());
      }
    }
    const auto rest = detector.finish();
    events.insert(events.end(), rest.begin(), rest.end());
    judge(features, events, length, score);
    score.km += length / 1000.0;
    score.samples += detector.counts().samples;
  }
  std::sort(score.errors.begin(), score.errors.end());
  std::sort(score.normalised.begin(), score.normalised.end());
  return score;
}

double share_below(const std::vector<double>& sorted, double limit) {
  const auto below = std::lower_bound(sorted.begin(), sorted.end(), limit) - sorted.begin();
  return static_cast<double>(below) / static_cast<double>(sorted.size());
}

double quantile(const std::vector<double>& sorted, double share) {
  return sorted.at(static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1)));
}

void print(double snr, const Score& score) {
  std::printf(
      "%5.1f dB: %4d of %4d welds found, %6.2f %%; %2d false in %4.0f km, %.3f per km; position "
      "p50 %.1f p95 %.1f worst %.1f mm; %.1f %% within 1.96 sigma\n",
      snr, score.found, score.welds, 100.0 * score.found / score.welds, score.wrong, score.km,
      score.wrong / score.km, 1e3 * quantile(score.errors, 0.5), 1e3 * quantile(score.errors, 0.95),
      1e3 * score.errors.back(), 100.0 * share_below(score.normalised, 1.96));
  std::fflush(stdout);
}

TEST(WeldDetectorScore, At12DecibelsItFindsThemAll) {
  const Score score = run(12.0, 20, 2000.0);
  print(12.0, score);
  EXPECT_GE(score.found, 0.995 * score.welds);
  EXPECT_LE(score.wrong, 0.1 * score.km);
  EXPECT_LE(quantile(score.errors, 0.95), 0.005);
  EXPECT_GE(share_below(score.normalised, 1.96), 0.95);
}

TEST(WeldDetectorScore, TheNoiseIsKnownFromTheStart) {
  const Score score = run(18.0, 200, 12.0);  // the first joint only
  print(18.0, score);
  EXPECT_EQ(score.wrong, 0);
}

TEST(WeldDetectorScore, GetsBetterWithLessNoise) {
  double last = 0.0;
  for (const double snr : {6.0, 9.0, 15.0, 18.0, 24.0}) {
    const Score score = run(snr, 20, 250.0);
    print(snr, score);
    const double found = static_cast<double>(score.found) / score.welds;
    EXPECT_GE(found, last - 0.01) << snr;
    EXPECT_LE(score.wrong, 0.4 * score.km) << snr;
    last = found;
  }
  EXPECT_GE(last, 0.99);
}

}  // namespace
}  // namespace pipescout::odometry
