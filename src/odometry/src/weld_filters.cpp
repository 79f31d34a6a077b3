// SPDX-License-Identifier: Apache-2.0
#include "weld_filters.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace pipescout::odometry {

namespace {

/// Half the distance between the lobes over the deviation of a lobe. The real passes (data set
/// eddy_current_passes) lie between 1.2 and 1.8.
constexpr double kSlenderness = 1.4;
constexpr double kReachDeviations = 4.0;  // of a lobe, beyond its middle

}  // namespace

FilterOutput apply(std::span<const double> taps, const double* x, const double* y) noexcept {
  // Each tap is loaded once, for x and y; sums of four do not wait for one another.
  using Two = Eigen::Array2d;
  using Four = Eigen::Array4d;
  Four re = Four::Zero();
  Four im = Four::Zero();
  std::size_t i = 0;
  for (; i + 4 <= taps.size(); i += 4) {
    const Four weights = Eigen::Map<const Four>(taps.data() + i);
    re += weights * Eigen::Map<const Four>(x + i);
    im += weights * Eigen::Map<const Four>(y + i);
  }
  Two re_pair = re.head<2>() + re.tail<2>();
  Two im_pair = im.head<2>() + im.tail<2>();
  if (i + 2 <= taps.size()) {
    const Two weights = Eigen::Map<const Two>(taps.data() + i);
    re_pair += weights * Eigen::Map<const Two>(x + i);
    im_pair += weights * Eigen::Map<const Two>(y + i);
    i += 2;
  }
  double re_sum = re_pair.sum();
  double im_sum = im_pair.sum();
  if (i < taps.size()) {
    re_sum += taps[i] * x[i];
    im_sum += taps[i] * y[i];
  }
  return {re_sum, im_sum};
}

WeldFilter make_weld_filter(double half_width) {
  WeldFilter filter;
  filter.half_width = half_width;
  const double deviation = half_width / kSlenderness;
  filter.half = static_cast<int>(std::ceil(half_width + kReachDeviations * deviation));
  const auto size = static_cast<std::size_t>(2 * filter.half + 1);
  filter.taps.resize(size);
  filter.even_taps.resize(size);
  const auto index = [&](std::size_t i) { return static_cast<double>(i) - filter.half; };
  const auto bell = [](double u) { return std::exp(-u * u / 2.0); };
  double along_line = 0.0;
  double line = 0.0;
  double level = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    const double u = index(i) / deviation;
    filter.taps[i] = bell(u - kSlenderness) - bell(u + kSlenderness);
    filter.even_taps[i] = bell(u - kSlenderness) + bell(u + kSlenderness);
    along_line += filter.taps[i] * index(i);
    line += index(i) * index(i);
    level += filter.even_taps[i] / static_cast<double>(size);
  }
  for (double u = 0.0; u <= 2.0 * kSlenderness; u += 0.01) {  // it may lie between two cells
    filter.peak = std::max(filter.peak, bell(u - kSlenderness) - bell(u + kSlenderness));
  }
  double energy = 0.0;
  double even_energy = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    filter.taps[i] -= along_line / line * index(i);  // constants are out already: it is odd
    filter.even_taps[i] -= level;                    // and lines: it is even
    energy += filter.taps[i] * filter.taps[i];
    even_energy += filter.even_taps[i] * filter.even_taps[i];
  }
  for (std::size_t i = 0; i < size; ++i) {
    filter.taps[i] /= std::sqrt(energy);
    filter.even_taps[i] /= even_energy;
  }
  filter.peak /= std::sqrt(energy);
  filter.even_deviation = 1.0 / std::sqrt(even_energy);
  for (std::size_t i = 1; i < size; ++i) {
    const double slope = filter.taps[i] - filter.taps[i - 1];
    filter.rho += slope * slope;
  }
  return filter;
}

std::size_t weld_filter_count(double smallest_half_width, double largest_half_width) {
  // Between two filters a pulse is off by the root of their ratio: by 1.18 at most, which costs 15
  // %.
  constexpr double kLargestRatio = 1.4;
  const double steps = std::log(largest_half_width / smallest_half_width) / std::log(kLargestRatio);
  return 1 + static_cast<std::size_t>(std::ceil(steps - 1e-9));
}

std::vector<WeldFilter> make_weld_filters(double smallest_half_width, double largest_half_width,
                                          std::size_t count) {
  std::vector<WeldFilter> filters;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.5;
    filters.push_back(make_weld_filter(smallest_half_width *
                                       std::pow(largest_half_width / smallest_half_width, share)));
  }
  return filters;
}

double false_alarms_per_cell(std::span<const WeldFilter> filters, std::size_t channels,
                             double threshold) {
  const auto c = static_cast<double>(channels);
  double slopes = 0.0;
  for (const auto& filter : filters) {
    slopes += std::sqrt(filter.rho / std::numbers::pi);
  }
  return slopes * std::exp((c - 0.5) * std::log(threshold) - std::lgamma(c) - threshold);
}

}  // namespace pipescout::odometry
