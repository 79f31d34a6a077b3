// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "distance_grid.hpp"
#include "weld_filters.hpp"

namespace pipescout::odometry {

/// The doublet that fits a peak best.
struct WeldShape {
  bool fitted = false;      ///< false: the grid does not hold enough around the peak
  double half_width = 0.0;  ///< cells
  double rho = 0.0;         ///< of the doublet, as in `WeldFilter`
  double centre = 0.0;      ///< cells, the middle of cell k is k
  double match = 0.0;       ///< share of the energy, noise taken off, that it explains
  /// Heights of the lobes as (upper - lower) / (upper + lower): 0 for a doublet, 1 or -1 for a lone
  /// bump; a mean over the channels.
  double asymmetry = 0.0;
  double asymmetry_deviation = 0.0;  ///< of it, by noise
  double peak = 0.0;                 ///< largest magnitude, channel 0
  double phase = 0.0;                ///< rad, of the lobe at the lower side, channel 0
  double missing = 0.0;              ///< share of the doublet's energy that lies in gaps
};

/// Fits doublets of many widths, from well below to well above those of welds: what is no weld is
/// found out because another width fits better. Takes no memory after construction.
class WeldShapeFitter {
 public:
  /// Rows of the grid: x and y of each channel, then `offset_row` and `missing_row`.
  struct Rows {
    std::size_t channels = 1;
    std::size_t offset = 0;   ///< where in the cell its samples were on average, cells
    std::size_t missing = 0;  ///< 1 in gaps, else 0
  };
  WeldShapeFitter(double smallest_half_width, double largest_half_width, const Rows& rows);

  /// `variances`: of the output of a filter of the smallest half width in noise, one per channel,
  /// for x and for y. `redness`: that variance goes with the width to this power (0 for white
  /// noise, 1 for 1/f); widths are compared with that in mind, or slow drifts would look like wide
  /// pulses.
  [[nodiscard]] WeldShape fit(const DistanceGrid& grid, std::int64_t peak,
                              std::span<const double> variances, double redness) const;

  /// Cells on each side that the widest filter needs, wherever the middle turns out to be.
  [[nodiscard]] int reach() const noexcept { return filters_.back().half + kMostMoves; }

 private:
  static constexpr int kMostMoves = 4;  // cells, from the peak to the middle of the doublet

  struct Best {
    std::size_t filter = 0;
    std::size_t count = 0;  // of filters for which the grid holds enough
    double whitened = -1.0;
  };
  [[nodiscard]] Best best_width(const DistanceGrid& grid, std::int64_t centre,
                                std::span<const double> variances, double redness) const;
  void measure_asymmetry(const WeldFilter& filter, const DistanceGrid& grid, std::int64_t centre,
                         std::span<const double> variances, double redness, WeldShape& shape) const;
  [[nodiscard]] double strength(const WeldFilter& filter, const DistanceGrid& grid,
                                std::int64_t centre, std::span<const double> variances) const;
  [[nodiscard]] double match(const WeldFilter& filter, const DistanceGrid& grid,
                             std::int64_t centre, std::span<const double> variances) const;

  Rows rows_;
  double smallest_half_width_;
  std::vector<WeldFilter> filters_;
};

}  // namespace pipescout::odometry
