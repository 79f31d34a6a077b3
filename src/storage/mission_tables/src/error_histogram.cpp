// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_tables/error_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipescout {

namespace {

constexpr double kSmallest = 1e-7;
const double kLogarithmOfWidth = std::log(1.01);

}  // namespace

void ErrorHistogram::add(double error) noexcept {
  const double value = std::abs(error);
  if (!std::isfinite(value)) {
    return;
  }
  const double bin = std::log(std::max(value, kSmallest) / kSmallest) / kLogarithmOfWidth;
  ++bins_[static_cast<std::size_t>(std::min(bin, static_cast<double>(kBins - 1)))];
  ++count_;
  largest_ = std::max(largest_, value);
  sum_of_squares_ += value * value;
}

double ErrorHistogram::quantile(double share) const noexcept {
  if (count_ == 0) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    below += bins_[bin];
    if (below >= wanted) {
      const double middle =
          kSmallest * std::exp((static_cast<double>(bin) + 0.5) * kLogarithmOfWidth);
      return std::min(middle, largest_);
    }
  }
  return largest_;
}

double ErrorHistogram::largest() const noexcept {
  return count_ == 0 ? std::numeric_limits<double>::quiet_NaN() : largest_;
}

double ErrorHistogram::root_mean_square() const noexcept {
  return count_ == 0 ? std::numeric_limits<double>::quiet_NaN()
                     : std::sqrt(sum_of_squares_ / static_cast<double>(count_));
}

}  // namespace pipescout
