// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace pipescout {

/// A span of time, in nanoseconds.
using Duration = std::chrono::nanoseconds;

/// A point in ROS time: nanoseconds since the Unix epoch, or since the start of a simulation when
/// `/clock` drives it. Message stamps are `Time`.
using Time = std::chrono::sys_time<std::chrono::nanoseconds>;

/// A point on the steady clock of this machine; never leaves the process.
using SteadyTime = std::chrono::time_point<std::chrono::steady_clock, std::chrono::nanoseconds>;

[[nodiscard]] inline SteadyTime steady_now() noexcept {
  return std::chrono::time_point_cast<Duration>(std::chrono::steady_clock::now());
}

/// `time + span`, saturating at the latest time. `span` must not be negative.
template <class Clock>
[[nodiscard]] constexpr std::chrono::time_point<Clock, Duration> add_saturated(
    std::chrono::time_point<Clock, Duration> time, Duration span) noexcept {
  using Point = std::chrono::time_point<Clock, Duration>;
  const bool fits = time.time_since_epoch() <= Duration::zero() || span <= Point::max() - time;
  return fits ? time + span : Point::max();
}

/// Seconds as a floating point number, for formulas and output.
[[nodiscard]] constexpr double to_seconds(Duration duration) noexcept {
  return std::chrono::duration<double>(duration).count();
}

/// The nearest duration to a number of seconds. Saturates; NaN becomes zero.
[[nodiscard]] Duration from_seconds(double seconds) noexcept;

}  // namespace pipescout
