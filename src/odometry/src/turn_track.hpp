// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>

namespace pipescout::odometry::internal {

/// How far a robot has turned, from yaw rates: their integral by the trapezoidal rule.
class TurnTrack {
 public:
  /// `maximum_gap`: s, see `OdometerStream::push_yaw_rate`.
  explicit TurnTrack(double maximum_gap) : maximum_gap_(maximum_gap) {}

  void push(double time, double rate);
  /// rad, since the first rate, to the left positive. Between rates interpolated; after the last
  /// one extrapolated by it, over `maximum_gap` at most; before those that are kept, the oldest.
  [[nodiscard]] double at(double time) const;
  /// The clocks were set by `leap` seconds.
  void shift(double leap);

 private:
  struct Entry {
    double time = -std::numeric_limits<double>::infinity();  // s
    double rate = 0.0;                                       // rad/s
    double heading = 0.0;                                    // rad
  };
  // 2.5 s of a gyroscope of 200 Hz: longer than ticks wait for late odometers.
  static constexpr std::size_t kKept = 512;

  [[nodiscard]] const Entry& back(std::size_t age) const {
    return ring_[(next_ + kKept - 1 - age) % kKept];
  }

  double maximum_gap_;
  std::array<Entry, kKept> ring_{};
  std::size_t next_ = 0;
  std::size_t count_ = 0;
};

}  // namespace pipescout::odometry::internal
