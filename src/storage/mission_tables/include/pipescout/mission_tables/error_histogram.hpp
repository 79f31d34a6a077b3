// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace pipescout {

/// Quantiles of any number of absolute errors in bounded memory: the bins are 1 % wide, from 1e-7
/// to 1e3 of whatever unit. Allocates nothing.
class ErrorHistogram {
 public:
  /// Adds the absolute value. Values that are not finite are ignored.
  void add(double error) noexcept;

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  /// The value that a share of (0, 1] of the errors does not exceed, to 0.5 %; NaN when there is
  /// none.
  [[nodiscard]] double quantile(double share) const noexcept;
  /// Exact, like the RMS; both are NaN without errors.
  [[nodiscard]] double largest() const noexcept;
  [[nodiscard]] double root_mean_square() const noexcept;

 private:
  static constexpr std::size_t kBins = 2316;

  std::array<std::uint64_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  double largest_ = 0.0;
  double sum_of_squares_ = 0.0;
};

}  // namespace pipescout
