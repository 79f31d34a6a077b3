// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "pipescout/csv/csv_stamp.hpp"

namespace pipescout {

/// Decimation of a stream: at most one message per period, by their stamps. Pure; not thread-safe.
class Thinning {
 public:
  /// `period` is not negative; zero: all are kept.
  explicit Thinning(std::chrono::nanoseconds period = std::chrono::nanoseconds::zero())
      : period_(period) {}

  /// Whether a period has passed since the last kept message. Because streams are not synchronous
  /// with the period, a message up to a hundredth of a period (at most 5 ms) early is due, as is
  /// one with an earlier stamp, because the clock was restarted.
  [[nodiscard]] bool due(Stamp stamp) const noexcept;
  /// Marks a message as kept.
  void keep(Stamp stamp) noexcept { last_ = stamp; }

 private:
  std::chrono::nanoseconds period_;
  std::optional<Stamp> last_;
};

}  // namespace pipescout
