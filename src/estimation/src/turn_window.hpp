// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pipescout::estimation {

/// Mean yaw rate of wheels over a time, of readings in any order. Constant memory.
class TurnWindow {
 public:
  /// Remembers `intervals` times `period` seconds before its newest reading.
  TurnWindow(double period, std::size_t intervals) : period_(period), ring_(intervals) {}

  /// s and rad/s; both finite.
  void add(double time, double rate) noexcept {
    if (!(std::abs(time) < kLargestTime)) {
      return;
    }
    const std::int64_t interval = interval_of(time);
    Sum& sum = ring_[place_of(interval)];
    if (sum.count == 0 || interval > sum.interval) {
      sum = {.interval = interval};
    }
    if (interval == sum.interval) {
      sum.rate += rate;
      ++sum.count;
    }
  }
  void forget() noexcept { ring_.assign(ring_.size(), Sum{}); }
  /// rad/s, of the intervals from the one of `from` to the one of `to`; 0 without a reading.
  [[nodiscard]] double mean(double from, double to) const noexcept {
    if (!(std::abs(from) < kLargestTime && std::abs(to) < kLargestTime)) {
      return 0;
    }
    double rate = 0;
    std::size_t count = 0;
    for (std::int64_t k = interval_of(from); k <= interval_of(to); ++k) {
      if (const Sum& sum = ring_[place_of(k)]; sum.interval == k) {
        rate += sum.rate;
        count += sum.count;
      }
    }
    return count > 0 ? rate / static_cast<double>(count) : 0;
  }

 private:
  struct Sum {
    std::int64_t interval = 0;
    double rate = 0;
    std::size_t count = 0;
  };
  [[nodiscard]] std::int64_t interval_of(double time) const noexcept {
    return static_cast<std::int64_t>(std::floor(time / period_));
  }
  [[nodiscard]] std::size_t place_of(std::int64_t interval) const noexcept {
    const auto size = static_cast<std::int64_t>(ring_.size());
    return static_cast<std::size_t>((interval % size + size) % size);
  }

  static constexpr double kLargestTime = 1e12;  // s: intervals are counted by integers

  double period_;
  std::vector<Sum> ring_;
};

}  // namespace pipescout::estimation
