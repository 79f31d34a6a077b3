// SPDX-License-Identifier: Apache-2.0
#include "core/rate_window.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>

namespace pipescout::host {

RateWindow::RateWindow(std::size_t window) : window_(window) {
  if (window == 0) {
    throw std::invalid_argument("window = 0 must be at least 1");
  }
}

void RateWindow::arrived(SteadyTime now) {
  if (last_) {
    intervals_.push_back(to_seconds(now - *last_));
    if (intervals_.size() > window_) {
      intervals_.pop_front();
    }
  }
  last_ = now;
}

std::optional<RateWindow::Statistics> RateWindow::statistics() const {
  if (intervals_.empty()) {
    return std::nullopt;
  }
  const auto count = static_cast<double>(intervals_.size());
  const double mean = std::accumulate(intervals_.begin(), intervals_.end(), 0.0) / count;
  double squares = 0.0;
  for (const double interval : intervals_) {
    squares += (interval - mean) * (interval - mean);
  }
  Statistics result;
  result.rate = mean > 0.0 ? 1.0 / mean : 0.0;
  const auto [min, max] = std::minmax_element(intervals_.begin(), intervals_.end());
  result.min = *min;
  result.max = *max;
  result.standard_deviation = std::sqrt(squares / count);
  result.window = intervals_.size();
  return result;
}

std::string to_string(const RateWindow::Statistics& statistics) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "average rate: %.3f\n\tmin: %.3fs max: %.3fs std dev: %.5fs window: %zu",
                statistics.rate, statistics.min, statistics.max, statistics.standard_deviation,
                statistics.window);
  return text.data();
}

}  // namespace pipescout::host
