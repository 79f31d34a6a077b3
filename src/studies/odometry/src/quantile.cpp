// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/quantile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipescout::odometry_study {

double quantile(std::vector<double> values, double part) {
  if (values.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto size = static_cast<double>(values.size());
  // 0.95 * 20 is a little more than 19 in binary.
  constexpr double kRounding = 1e-9;
  const double rank = std::clamp(std::ceil(part * size - kRounding), 1.0, size);
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(rank) - 1;
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

}  // namespace pipescout::odometry_study
