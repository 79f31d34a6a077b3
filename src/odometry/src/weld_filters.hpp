// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace pipescout::odometry {

/// A filter matched to a doublet: two bells of opposite sign, as slender as those of real passes.
/// Made blind to constants and straight lines, then scaled to unit energy: white noise keeps its
/// variance, and the squared output is the energy that the best doublet explains there.
struct WeldFilter {
  double half_width = 0.0;  ///< cells, half the distance between the lobes
  int half = 0;             ///< taps on each side
  std::vector<double> taps;
  double rho = 0.0;   ///< 1/cells^2, mean square slope over mean square
  double peak = 0.0;  ///< magnitude of the doublet, straight line and all, for an output of 1
  /// The same two bells with equal signs, blind to constants, scaled to one bell of height 1 on
  /// each side being an output of 1.
  std::vector<double> even_taps;
  double even_deviation = 0.0;  ///< of its output in white noise of 1
};

/// Of a filter where x and y of a channel are its two parts.
struct FilterOutput {
  double re = 0.0;
  double im = 0.0;
  [[nodiscard]] double energy() const noexcept { return re * re + im * im; }
};

/// `x`, `y`: as many values as there are taps.
[[nodiscard]] FilterOutput apply(std::span<const double> taps, const double* x,
                                 const double* y) noexcept;

[[nodiscard]] WeldFilter make_weld_filter(double half_width);

/// `count` filters, at least 1, evenly from one half width to the other in their logarithm.
[[nodiscard]] std::vector<WeldFilter> make_weld_filters(double smallest_half_width,
                                                        double largest_half_width,
                                                        std::size_t count);

/// As many as keep a pulse between two of them within 15 % of its energy.
[[nodiscard]] std::size_t weld_filter_count(double smallest_half_width, double largest_half_width);

/// The sum in the comment on `weld_threshold`, for each cell.
[[nodiscard]] double false_alarms_per_cell(std::span<const WeldFilter> filters,
                                           std::size_t channels, double threshold);

}  // namespace pipescout::odometry
