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
constexpr double kNoise = 4.5;   // sigma from the median, x and y together
/// The same for a sample that follows a spike: spikes ring.
constexpr double kRinging = 2.5;
constexpr int kRingingSamples = 2;
/// Times what the three middle samples are spread more than by noise: on a slope they are.
constexpr double kSpread = 3.0;
constexpr double kSpreadOfNoise = 1.5;  // sigma

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

double SpikeGate::bend(std::size_t channel) noexcept {
  double sum = 0.0;
  for (std::size_t part = 0; part < 2; ++part) {
    const double bend =
        std::abs(value(kMiddle, channel, part) -
                 (value(kMiddle - 1, channel, part) + value(kMiddle + 1, channel, part)) / 2.0);
    RunningMedian& median = bends_[2 * channel + part];
    if (!median.started()) {
      median.start(bend, 1.0);
    }
    const double ratio = bend / (kSigmaOfBend * median.value());
    sum += ratio * ratio;
    median.update(bend);
  }
  return sum;
}

double SpikeGate::distance_from_others(std::size_t channel) const noexcept {
  double sum = 0.0;
  for (std::size_t part = 0; part < 2; ++part) {
    std::array<double, kWindow> sorted{};
    for (std::size_t age = 0; age < kWindow; ++age) {
      sorted[age] = value(age, channel, part);
    }
    std::sort(sorted.begin(), sorted.end());
    const double sigma = kSigmaOfBend * bends_[2 * channel + part].value();
    const double spread = sorted[kMiddle + 1] - sorted[kMiddle - 1];
    const double slope = std::max(0.0, spread - kSpreadOfNoise * sigma);
    const double off = std::abs(value(kMiddle, channel, part) - sorted[kMiddle]);
    const double surplus = std::max(0.0, off - kSpread * slope) / sigma;
    sum += surplus * surplus;
  }
  return sum;
}

bool SpikeGate::is_spike() noexcept {
  bool spike = false;
  for (std::size_t c = 0; c < channels_; ++c) {
    const double limit = ringing_ > 0 ? kRinging : kNoise;
    const double bent = bend(c);
    if (ringing_ > 0 || bent > kScreen * kScreen) {
      spike = spike || distance_from_others(c) > limit * limit;
    }
  }
  ringing_ = spike ? kRingingSamples : std::max(0, ringing_ - 1);
  return spike;
}

const SpikeGate::Sample* SpikeGate::push(double distance, std::span<const Impedance> channels,
                                         bool& spike) {
  Sample& sample = samples_[next_];
  next_ = (next_ + 1) % kRing;
  sample.distance = distance;
  std::copy(channels.begin(), channels.end(), sample.values.begin());
  held_ = std::min(held_ + 1, kWindow);
  sample.frozen = false;
  spike = false;
  if (held_ <= kMiddle) {
    return nullptr;
  }
  spike = held_ == kWindow && !at(kMiddle).frozen && is_spike();
  return spike || at(kMiddle).frozen ? nullptr : &at(kMiddle);
}

std::size_t SpikeGate::freeze(std::size_t count) noexcept {
  std::size_t frozen = 0;
  for (std::size_t age = 0; age < std::min({count, kMiddle, held_}); ++age) {
    Sample& sample = samples_[(next_ + 2 * kRing - 1 - age) % kRing];
    frozen += sample.frozen ? 0 : 1;
    sample.frozen = true;
  }
  return frozen;
}

const SpikeGate::Sample* SpikeGate::drain() noexcept {
  // The youngest three are those that were not returned.
  for (std::size_t left = std::min(held_, kMiddle); left > 0;) {
    held_ = --left;
    if (!at(left).frozen) {
      return &at(left);
    }
  }
  held_ = 0;
  return nullptr;
}

}  // namespace pipescout::odometry
