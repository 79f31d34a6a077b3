// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/detector_score.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "pipescout/odometry/weld_detector.hpp"
#include "pipescout/simulation/eddy_current_signal.hpp"

namespace pipescout::odometry_study {
namespace {

using odometry::WeldEvent;

constexpr double kClose = 0.05;  // m
constexpr double kEnds = 1.0;    // m

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
           const std::vector<WeldEvent>& events, double length, DetectorScore& score) {
  std::vector<bool> used(events.size());
  for (const auto& feature : features) {
    if (feature.kind != simulation::FeatureKind::kWeld) {
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

}  // namespace

DetectorScore& DetectorScore::operator+=(const DetectorScore& other) {
  welds += other.welds;
  found += other.found;
  wrong += other.wrong;
  km += other.km;
  samples += other.samples;
  errors.insert(errors.end(), other.errors.begin(), other.errors.end());
  normalised.insert(normalised.end(), other.normalised.begin(), other.normalised.end());
  return *this;
}

double DetectorScore::found_percent() const {
  return 100.0 * found / welds;
}

double DetectorScore::false_per_km() const {
  return wrong / km;
}

double DetectorScore::share_within(double sigmas) const {
  const auto within = std::count_if(normalised.begin(), normalised.end(),
                                    [sigmas](double value) { return value < sigmas; });
  return static_cast<double>(within) / static_cast<double>(normalised.size());
}

DetectorScore score_detector(double peak_snr, double length, std::uint64_t seed) {
  constexpr std::uint64_t kSignalSeed = 1'000'000;  // apart from that of the pipe
  const auto features = simulation::draw_features({.length = length}, seed);
  const simulation::EddyCurrentParameters parameters{.peak_snr = peak_snr};
  simulation::EddyCurrentSignal signal(parameters, features, seed + kSignalSeed);
  odometry::WeldDetector detector({});
  Drive drive(parameters.sample_rate);
  std::vector<WeldEvent> events;
  const auto keep = [&events](std::span<const WeldEvent> found) {
    events.insert(events.end(), found.begin(), found.end());
  };
  for (double at = 0.0; at < length; at = drive.next()) {
    const auto sample = signal.next(at);
    if (sample.fault != simulation::SampleFault::kMissing) {
      const odometry::Impedance value{sample.value.real(), sample.value.imag()};
      keep(detector.update(at, {&value, 1}));
    }
  }
  keep(detector.finish());
  DetectorScore score{.km = length / 1000.0, .samples = detector.counts().samples};
  judge(features, events, length, score);
  return score;
}

}  // namespace pipescout::odometry_study
