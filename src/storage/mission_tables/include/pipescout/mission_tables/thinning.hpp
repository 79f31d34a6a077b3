// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "pipescout/csv/csv_stamp.hpp"

namespace pipescout {

/// Which messages of a stream are kept: no more than one in each period, by their stamps. Pure;
/// not thread-safe.
class Thinning {
 public:
  /// `period` is not negative; zero: all are kept.
  explicit Thinning(std::chrono::nanoseconds period = std::chrono::nanoseconds::zero())
      : period_(period) {}

  /// Whether a period has passed since the one that was kept last. Streams do not tick by this
  /// clock: one that is a hundredth of a period (at most 5 ms) early counts as due, and so does a
  /// stamp from before, for the clock began again.
  [[nodiscard]] bool due(Stamp stamp) const noexcept;
  /// It is kept.
  void keep(Stamp stamp) noexcept { last_ = stamp; }

 private:
  std::chrono::nanoseconds period_;
  std::optional<Stamp> last_;
};

}  // namespace pipescout
