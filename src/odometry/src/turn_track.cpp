// SPDX-License-Identifier: Apache-2.0
#include "turn_track.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::odometry::internal {

void TurnTrack::push(double time, double rate) {
  if (!std::isfinite(time) || !std::isfinite(rate) || (count_ > 0 && time <= back(0).time)) {
    return;
  }
  Entry entry{.time = time, .rate = rate};
  if (count_ > 0) {
    const Entry& last = back(0);
    const double duration = time - last.time;
    entry.heading = last.heading;
    if (duration <= maximum_gap_) {
      entry.heading += 0.5 * (last.rate + rate) * duration;
    }
  }
  ring_[next_] = entry;
  next_ = (next_ + 1) % kKept;
  count_ = std::min(count_ + 1, kKept);
}

double TurnTrack::at(double time) const {
  if (count_ == 0) {
    return 0.0;
  }
  const Entry* after = nullptr;
  for (std::size_t age = 0; age < count_; ++age) {
    const Entry& before = back(age);
    if (before.time > time) {
      after = &before;
      continue;
    }
    if (after == nullptr) {
      return before.heading + before.rate * std::min(time - before.time, maximum_gap_);
    }
    const double share = (time - before.time) / (after->time - before.time);
    return before.heading + share * (after->heading - before.heading);
  }
  return after->heading;
}

void TurnTrack::shift(double leap) {
  for (Entry& entry : ring_) {
    entry.time += leap;
  }
}

}  // namespace pipescout::odometry::internal
