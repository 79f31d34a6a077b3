// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// The time of a bag that is played, told from the steady clock: it runs at a rate, stands while
/// paused, and can be set. Begins paused, at the time it is made with.
class PlaybackClock {
 public:
  explicit PlaybackClock(Time start, double rate = 1.0) : bag_(start), rate_(rate) {}

  [[nodiscard]] Time time(SteadyTime now) const;
  /// When the bag's time will be `time`; never while paused. `now` if it is over.
  [[nodiscard]] SteadyTime when(Time time, SteadyTime now) const;

  [[nodiscard]] bool paused() const noexcept { return paused_; }
  [[nodiscard]] double rate() const noexcept { return rate_; }

  void pause(SteadyTime now);
  /// The time goes on from what it is.
  void resume(SteadyTime now);
  /// Above zero.
  void set_rate(double rate, SteadyTime now);
  void set(Time time, SteadyTime now);

 private:
  Time bag_;             // the bag's time ...
  SteadyTime steady_{};  // ... at this time, from which on it runs
  double rate_;
  bool paused_ = true;
};

}  // namespace pipescout
