// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "pipescout/odometry/weld_detector.hpp"
#include "weld_background.hpp"

namespace pipescout::odometry {

/// Takes out of a stream of samples those that stand out of their neighbours in time: spikes of up
/// to three samples. The slopes and peaks of pulses pass, as long as they are some samples wide.
class SpikeGate {
 public:
  static constexpr std::size_t kWindow = 7;

  struct Sample {
    double distance = 0.0;
    bool frozen = false;
    std::array<Impedance, kMaxEddyCurrentChannels> values{};
  };

  SpikeGate(std::size_t channels, double noise_floor);

  /// Returns the sample that came three samples before, or nullptr when there is none or it is a
  /// spike.
  const Sample* push(double distance, std::span<const Impedance> channels, bool& spike);

  /// The latest `count` samples, as far as they have not been returned, never will be. Returns how
  /// many.
  std::size_t freeze(std::size_t count) noexcept;

  /// At the end: the samples that have not been returned, unjudged, one by one; then nullptr.
  const Sample* drain() noexcept;

  /// Whether a sample repeats the one that was pushed last bit by bit, in all channels.
  [[nodiscard]] bool repeats(std::span<const Impedance> channels) const noexcept;

 private:
  [[nodiscard]] const Sample& at(std::size_t age) const noexcept {
    return samples_[(next_ + 2 * kRing - 1 - age) % kRing];
  }
  [[nodiscard]] double value(std::size_t age, std::size_t channel,
                             std::size_t part) const noexcept {
    const Impedance& impedance = at(age).values[channel];
    return part == 0 ? impedance.x : impedance.y;
  }
  /// Of the middle sample from the mean of its neighbours, squared, sigma^2; learns sigma.
  [[nodiscard]] double bend(std::size_t channel) noexcept;
  /// From the median of the window, what a slope would explain taken off, squared, sigma^2.
  [[nodiscard]] double distance_from_others(std::size_t channel) const noexcept;
  [[nodiscard]] bool is_spike() noexcept;

  static constexpr std::size_t kRing = 8;
  static constexpr std::size_t kMiddle = kWindow / 2;

  std::size_t channels_;
  std::array<Sample, kRing> samples_{};
  std::size_t next_ = 0;
  std::size_t held_ = 0;
  int ringing_ = 0;                   // samples that may belong to the spike before
  std::vector<RunningMedian> bends_;  // x and y of each channel
};

}  // namespace pipescout::odometry
