// SPDX-License-Identifier: Apache-2.0
#include "transform_history.hpp"

#include <algorithm>

namespace pipescout {
namespace {

/// Steps from the guessed place that are tried before the search halves what is left.
constexpr std::size_t kSteps = 8;

}  // namespace

TransformHistory::Insertion TransformHistory::insert(const Sample& sample, Duration reach,
                                                     std::size_t capacity) {
  Insertion result = Insertion::kTaken;
  if (!empty() && sample.time <= newest()) {
    // Compared without a sum, which may not fit.
    if (newest() - sample.time > reach) {
      clear();
      result = Insertion::kBeganAnew;
    } else {
      const std::size_t place = not_before(sample.time);
      if (samples_[place].time == sample.time) {
        return Insertion::kRepeated;
      }
      samples_.insert(samples_.begin() + static_cast<std::ptrdiff_t>(place), sample);
      if (size() > capacity) {
        ++first_;
      }
      oldest_ = samples_[first_].time;
      return result;
    }
  }
  samples_.push_back(sample);
  newest_ = sample.time;
  while (size() > capacity || newest_ - samples_[first_].time > reach) {
    ++first_;
  }
  oldest_ = samples_[first_].time;
  if (first_ > samples_.size() / 2) {
    samples_.erase(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(first_));
    first_ = 0;
  }
  return result;
}

void TransformHistory::clear() {
  samples_.clear();
  first_ = 0;
}

std::size_t TransformHistory::not_before(Time time) const noexcept {
  std::size_t low = first_;  // the answer is in [low, high]
  std::size_t high = samples_.size() - 1;
  if (time <= samples_[low].time) {
    return low;
  }
  // Most publishers keep a rate: the place that a time would have at that rate is near.
  const double part = static_cast<double>((time - samples_[low].time).count()) /
                      static_cast<double>((samples_[high].time - samples_[low].time).count());
  std::size_t guess = low + static_cast<std::size_t>(part * static_cast<double>(high - low));
  guess = std::min(guess, high);
  for (std::size_t step = 0; step < kSteps; ++step) {
    if (samples_[guess].time < time) {
      low = ++guess;  // the newest is not before it, so this is no step beyond
    } else if (samples_[guess - 1].time < time) {
      return guess;  // guess > first_: that one is before it
    } else {
      high = --guess;
    }
  }
  const auto begin = samples_.begin();
  const auto found = std::lower_bound(
      begin + static_cast<std::ptrdiff_t>(low), begin + static_cast<std::ptrdiff_t>(high), time,
      [](const Sample& sample, Time wanted) { return sample.time < wanted; });
  return static_cast<std::size_t>(found - begin);
}

RigidTransform TransformHistory::at(Time time, Duration& gap) const noexcept {
  if (time == newest_) {
    return samples_.back().transform;
  }
  const std::size_t after = not_before(time);
  const Sample& later = samples_[after];
  if (later.time == time) {
    return later.transform;
  }
  const Sample& earlier = samples_[after - 1];
  const Duration between = later.time - earlier.time;
  gap = std::max(gap, between);
  const double part =
      static_cast<double>((time - earlier.time).count()) / static_cast<double>(between.count());
  return interpolate(earlier.transform, later.transform, part);
}

}  // namespace pipescout
