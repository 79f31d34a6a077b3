// SPDX-License-Identifier: Apache-2.0
#include "spike_gate.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::odometry {
namespace {

constexpr double kMemory = 2000.0;  // samples
/// A sample less the mean of its neighbours has in white noise a median magnitude of 0.826 sigma.
constexpr double kSigmaOfBend = 1.0 / 0.826;
constexpr double kScreen = 3.5;  // sigma; most samples need no second look
constexpr double kNoise = 5.0;   // sigma from the median
/// Times the spread of the three middle samples: on a slope the samples are spread, too.
constexpr double kSpread = 3.0;

}  // namespace

SpikeGate::SpikeGate(std::size_t channels, double noise_floor)
    : channels_(channels), bends_(2 * channels, RunningMedian(kMemory, noise_floor)) {}

bool SpikeGate::repeats(std::span<const Impedance> channels) const noexcept {
  if (held_ == 0) {
    return false;
  }
  const Sample& last = at(0);
  for (std::size_t c = 0; c < channels_; ++c) {
    if (channels[c].x != last.values[c].x || channels[c].y != last.values[c].y) {
      return false;
    }
  }
  return true;
}

bool SpikeGate::is_spike(std::size_t channel, double Impedance::*part,
                         RunningMedian& bend) const noexcept {
  const auto value = [&](std::size_t age) { return at(age).values[channel].*part; };
  const double middle = value(kMiddle);
  const double bent = std::abs(middle - (value(kMiddle - 1) + value(kMiddle + 1)) / 2.0);
  const double sigma = kSigmaOfBend * bend.value();
  if (bend.started()) {
    bend.update(bent, 1.0);
  } else {
    bend.start(bent, 1.0);
    return false;
  }
  if (bent < kScreen * sigma) {
    return false;
  }
  std::array<double, kWindow> sorted{};
  for (std::size_t age = 0; age < kWindow; ++age) {
    sorted[age] = value(age);
  }
  std::sort(sorted.begin(), sorted.end());
  const double spread = sorted[kMiddle + 1] - sorted[kMiddle - 1];
  return std::abs(middle - sorted[kMiddle]) > kNoise * sigma + kSpread * spread;
}

const SpikeGate::Sample* SpikeGate::push(double distance, std::span<const Impedance> channels,
                                         bool& spike) {
  Sample& sample = samples_[next_];
  next_ = (next_ + 1) % kRing;
  sample.distance = distance;
  std::copy(channels.begin(), channels.end(), sample.values.begin());
  held_ = std::min(held_ + 1, kWindow);
  spike = false;
  if (held_ <= kMiddle) {
    return nullptr;
  }
  if (held_ == kWindow) {
    for (std::size_t c = 0; c < channels_; ++c) {
      const bool x = is_spike(c, &Impedance::x, bends_[2 * c]);
      const bool y = is_spike(c, &Impedance::y, bends_[2 * c + 1]);
      spike = spike || x || y;
    }
  }
  return spike ? nullptr : &at(kMiddle);
}

const SpikeGate::Sample* SpikeGate::drain() noexcept {
  // The youngest three are those that were not returned.
  if (held_ == 0) {
    return nullptr;
  }
  const std::size_t left = std::min(held_, kMiddle);
  held_ = left - 1;
  return &at(left - 1);
}

}  // namespace pipescout::odometry
