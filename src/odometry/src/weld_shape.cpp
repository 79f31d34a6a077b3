// SPDX-License-Identifier: Apache-2.0
#include "weld_shape.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace pipescout::odometry {
namespace {

constexpr double kStep = 1.15;  // between widths; a parabola finds what lies between
constexpr double kBelow = 3.0;  // how far the widths go past those of welds
constexpr double kAbove = 2.2;
constexpr double kNarrowest = 0.8;  // cells; below, a doublet is two cells

using Row = Eigen::Map<const Eigen::ArrayXd>;

/// Where the parabola through (-1, left), (0, middle), (1, right) is largest, within [-1/2, 1/2].
double vertex(double left, double middle, double right) {
  const double curvature = left - 2.0 * middle + right;
  return curvature < 0.0 ? std::clamp((left - right) / (2.0 * curvature), -0.5, 0.5) : 0.0;
}

/// That parabola at u.
double parabola(double left, double middle, double right, double u) {
  return middle + u * ((right - left) / 2.0 + u * ((left + right) / 2.0 - middle));
}

/// Energy of a row of n values that a constant and a straight line leave.
double curved_energy(const double* values, Eigen::Index n) {
  const Row row(values, n);
  const double mean = row.mean();
  double along = 0.0;
  double line = 0.0;
  double energy = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double u = static_cast<double>(i) - 0.5 * static_cast<double>(n - 1);
    const double value = row(i) - mean;
    along += u * value;
    line += u * u;
    energy += value * value;
  }
  return energy - along * along / line;
}

/// `taps`, an odd number, around a cell.
FilterOutput apply_at(std::span<const double> taps, const DistanceGrid& grid, std::size_t channel,
                      std::int64_t centre) {
  const std::int64_t first = centre - static_cast<std::int64_t>(taps.size() / 2);
  return apply(taps, grid.window(2 * channel, first), grid.window(2 * channel + 1, first));
}

}  // namespace

WeldShapeFitter::WeldShapeFitter(double smallest_half_width, double largest_half_width,
                                 const Rows& rows)
    : rows_(rows), smallest_half_width_(smallest_half_width) {
  const double narrowest = std::max(kNarrowest, smallest_half_width / kBelow);
  const double widest = largest_half_width * kAbove;
  const auto steps = std::ceil(std::log(widest / narrowest) / std::log(kStep));
  filters_ = make_weld_filters(narrowest, widest, static_cast<std::size_t>(steps) + 1);
}

void WeldShapeFitter::measure_asymmetry(const WeldFilter& filter, const DistanceGrid& grid,
                                        std::int64_t centre, std::span<const double> variances,
                                        double redness, WeldShape& shape) const {
  double together = 0.0;
  double odd_energy = 0.0;
  for (std::size_t channel = 0; channel < rows_.channels; ++channel) {
    const FilterOutput odd = apply_at(filter.taps, grid, channel, centre);
    const FilterOutput even = apply_at(filter.even_taps, grid, channel, centre);
    const double weight = 1.0 / variances[channel];
    together += weight * filter.peak * (odd.re * even.re + odd.im * even.im);
    odd_energy += weight * filter.peak * filter.peak * odd.energy();
  }
  shape.asymmetry = together / odd_energy;
  shape.asymmetry_deviation = filter.even_deviation / std::sqrt(odd_energy) *
                              std::pow(filter.half_width / smallest_half_width_, redness / 2.0);
}

double WeldShapeFitter::strength(const WeldFilter& filter, const DistanceGrid& grid,
                                 std::int64_t centre, std::span<const double> variances) const {
  double sum = 0.0;
  for (std::size_t channel = 0; channel < rows_.channels; ++channel) {
    sum += apply_at(filter.taps, grid, channel, centre).energy() / (2.0 * variances[channel]);
  }
  return sum;
}

double WeldShapeFitter::match(const WeldFilter& filter, const DistanceGrid& grid,
                              std::int64_t centre, std::span<const double> variances) const {
  const auto n = static_cast<Eigen::Index>(filter.taps.size());
  const std::int64_t first = centre - filter.half;
  double explained = 0.0;
  double energy = 0.0;
  for (std::size_t channel = 0; channel < rows_.channels; ++channel) {
    const FilterOutput a = apply_at(filter.taps, grid, channel, centre);
    const double weight = 1.0 / variances[channel];
    explained += weight * a.energy();
    energy += weight * (curved_energy(grid.window(2 * channel, first), n) +
                        curved_energy(grid.window(2 * channel + 1, first), n));
    energy -=
        2.0 * static_cast<double>(n - 3);  // of the noise, the doublet's own direction left out
  }
  return energy > explained ? explained / energy : 1.0;
}

WeldShapeFitter::Best WeldShapeFitter::best_width(const DistanceGrid& grid, std::int64_t centre,
                                                  std::span<const double> variances,
                                                  double redness) const {
  Best best;
  for (std::size_t i = 0; i < filters_.size(); ++i) {
    const WeldFilter& filter = filters_[i];
    if (!grid.holds(centre - filter.half - 1, centre + filter.half + 1)) {
      break;
    }
    ++best.count;
    const double whitened =
        strength(filter, grid, centre, variances) * std::pow(filter.half_width, -redness);
    if (whitened > best.whitened) {
      best.filter = i;
      best.whitened = whitened;
    }
  }
  return best;
}

WeldShape WeldShapeFitter::fit(const DistanceGrid& grid, std::int64_t peak,
                               std::span<const double> variances, double redness) const {
  WeldShape shape;
  std::int64_t centre = peak;
  Best best = best_width(grid, centre, variances, redness);
  if (best.count < 3) {
    return shape;
  }
  for (int moves = 0; moves < kMostMoves; ++moves) {
    const WeldFilter& filter = filters_[best.filter];
    const double here = strength(filter, grid, centre, variances);
    const double below = strength(filter, grid, centre - 1, variances);
    const double above = strength(filter, grid, centre + 1, variances);
    if (here >= std::max(below, above)) {
      break;
    }
    centre += above > below ? 1 : -1;
    best = best_width(grid, centre, variances, redness);
  }
  const std::size_t count = best.count;
  const WeldFilter& filter = filters_[best.filter];
  const double ratio = filters_[1].half_width / filters_[0].half_width;
  shape.fitted = true;
  const auto energy = [&](std::size_t i) {
    return apply_at(filters_[i].taps, grid, 0, centre).energy();
  };
  double step = 0.0;
  double best_energy = energy(best.filter);
  if (best.filter > 0 && best.filter + 1 < count) {
    const auto whitened = [&](std::size_t i) {
      return strength(filters_[i], grid, centre, variances) *
             std::pow(filters_[i].half_width, -redness);
    };
    step = vertex(whitened(best.filter - 1), best.whitened, whitened(best.filter + 1));
    best_energy = parabola(energy(best.filter - 1), best_energy, energy(best.filter + 1), step);
  }
  shape.half_width = filter.half_width * std::pow(ratio, step);
  shape.rho = filter.rho;
  shape.match = match(filter, grid, centre, variances);
  // As long as a pulse is some cells wide, its peak goes with energy and width like this.
  shape.peak = filter.peak * std::sqrt(best_energy * std::pow(ratio, -step));

  measure_asymmetry(filter, grid, centre, variances, redness, shape);

  const FilterOutput a = apply_at(filter.taps, grid, 0, centre);
  shape.phase = std::atan2(-a.im, -a.re);  // the doublet is negative on the lower side

  const auto n = static_cast<Eigen::Index>(filter.taps.size());
  const Row taps(filter.taps.data(), n);
  const std::int64_t first = centre - filter.half;
  shape.missing = (taps.square() * Row(grid.window(rows_.missing, first), n)).sum();
  // The samples of a cell are not always around its middle; what counts is where the pulse is.
  const double offset = (taps.square() * Row(grid.window(rows_.offset, first), n)).sum();
  shape.centre = static_cast<double>(centre) + offset +
                 vertex(strength(filter, grid, centre - 1, variances),
                        strength(filter, grid, centre, variances),
                        strength(filter, grid, centre + 1, variances));
  return shape;
}

}  // namespace pipescout::odometry
