// SPDX-License-Identifier: Apache-2.0
#include "playback_clock.hpp"

#include <algorithm>

namespace pipescout {

Time PlaybackClock::time(SteadyTime now) const {
  if (paused_ || now <= steady_) {
    return bag_;
  }
  return add_saturated(bag_, from_seconds(to_seconds(now - steady_) * rate_));
}

SteadyTime PlaybackClock::when(Time time, SteadyTime now) const {
  if (paused_) {
    return SteadyTime::max();
  }
  const Duration ahead = std::max(time - bag_, Duration::zero());
  return std::max(add_saturated(steady_, from_seconds(to_seconds(ahead) / rate_)), now);
}

void PlaybackClock::pause(SteadyTime now) {
  bag_ = time(now);
  paused_ = true;
}

void PlaybackClock::resume(SteadyTime now) {
  if (paused_) {
    steady_ = now;
    paused_ = false;
  }
}

void PlaybackClock::set_rate(double rate, SteadyTime now) {
  bag_ = time(now);
  steady_ = std::max(now, steady_);
  rate_ = rate;
}

void PlaybackClock::set(Time time, SteadyTime now) {
  bag_ = time;
  steady_ = now;
}

}  // namespace pipescout
