// SPDX-License-Identifier: Apache-2.0
#include "ledger_adjustment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "banded_information.hpp"
#include "pipescout/statistics/quantile.hpp"

namespace pipescout::odometry {
namespace {

constexpr int kIterations = 10;
// Huber's weights: 95 % as efficient as least squares when all is normal, and convex: of two runs
// that disagree neither is taken for the truth.
constexpr double kHuberTuning = 1.345;
// Standard deviations by which most runs must miss the compromise to be said to disagree.
constexpr double kDisagreement = 3.0;
// 1/m^2: holds welds that no run ties to the others (a ledger cut by hand) where they are.
constexpr double kHold = 1e-8;
// A distance over more welds than this ties the ledger to nothing that nearer ones do not, and
// would make the normal equations full.
constexpr std::size_t kWidest = 1000;
constexpr double kApart = 1e-3;  // m, what the ledger's chainage rises by at least

/// A distance between two welds, by one run.
struct Distance {
  std::size_t from;  // index of the weld in the ledger
  std::size_t to;    // above `from`
  std::size_t run;
  double length;    // m, by the run's odometer
  double variance;  // m^2
};

std::vector<Distance> distances(const WeldLedger& ledger, double noise_variance) {
  struct Last {
    bool seen = false;
    std::size_t weld = 0;
    double chainage = 0.0;
    double variance = 0.0;
  };
  std::vector<Last> last(ledger.runs.size());
  std::vector<Distance> result;
  for (std::size_t k = 0; k < ledger.welds.size(); ++k) {
    for (const LedgerSighting& sighting : ledger.welds[k].sightings) {
      Last& before = last[sighting.run];
      const double variance = sighting.standard_deviation * sighting.standard_deviation;
      if (before.seen && k - before.weld <= kWidest) {
        // A run that was driven the other way counts down.
        const double length = std::abs(sighting.chainage - before.chainage);
        result.push_back({.from = before.weld,
                          .to = k,
                          .run = sighting.run,
                          .length = length,
                          .variance = variance + before.variance + noise_variance * length});
      }
      before = {.seen = true, .weld = k, .chainage = sighting.chainage, .variance = variance};
    }
  }
  return result;
}

/// Length by each run over length by the ledger, their mean 1; 1 for a run of no distance.
std::vector<double> estimate_scales(const std::vector<Distance>& distances,
                                    const std::vector<double>& weights,
                                    const std::vector<double>& x, std::size_t runs) {
  std::vector<double> measured(runs, 0.0);
  std::vector<double> expected(runs, 0.0);
  for (std::size_t e = 0; e < distances.size(); ++e) {
    const Distance& distance = distances[e];
    const double length = x[distance.to] - x[distance.from];
    measured[distance.run] += weights[e] * length * distance.length;
    expected[distance.run] += weights[e] * length * length;
  }
  std::vector<double> scales(runs, 1.0);
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t run = 0; run < runs; ++run) {
    if (expected[run] > 0.0) {
      scales[run] = measured[run] / expected[run];
      sum += scales[run];
      count += 1.0;
    }
  }
  for (std::size_t run = 0; run < runs; ++run) {
    scales[run] = expected[run] > 0.0 ? scales[run] * count / sum : 1.0;
  }
  return scales;
}

/// Residuals of the distances in standard deviations, not signed.
std::vector<double> misfits(const std::vector<Distance>& distances,
                            const std::vector<double>& scales, const std::vector<double>& x) {
  std::vector<double> result;
  for (const Distance& distance : distances) {
    const double residual =
        distance.length / scales[distance.run] - (x[distance.to] - x[distance.from]);
    result.push_back(std::abs(residual) / std::sqrt(distance.variance));
  }
  return result;
}

/// What each distance's standard deviation is to be multiplied with: where the median of the runs
/// misses by much, nobody knows who is right, and all of them become as uncertain as they are
/// apart.
std::vector<double> disagreements(const std::vector<Distance>& distances,
                                  const std::vector<double>& misfit, std::size_t welds) {
  std::vector<std::vector<double>> over_joint(welds);
  for (std::size_t e = 0; e < distances.size(); ++e) {
    for (std::size_t k = distances[e].from; k < distances[e].to; ++k) {
      over_joint[k].push_back(misfit[e]);
    }
  }
  std::vector<double> of_joint(welds, 1.0);
  for (std::size_t k = 0; k < welds; ++k) {
    std::vector<double>& values = over_joint[k];
    if (values.size() >= 2) {
      const double middle = statistics::quantile_in_place(values, 0.5);
      of_joint[k] = middle > kDisagreement ? middle : 1.0;
    }
  }
  std::vector<double> result;
  for (const Distance& distance : distances) {
    result.push_back(
        *std::max_element(of_joint.begin() + static_cast<std::ptrdiff_t>(distance.from),
                          of_joint.begin() + static_cast<std::ptrdiff_t>(distance.to)));
  }
  return result;
}

/// The weld whose chainage is the ledger's origin: the first that the first run saw.
std::size_t find_anchor(const WeldLedger& ledger) {
  const auto anchor =
      std::find_if(ledger.welds.begin(), ledger.welds.end(), [](const LedgerWeld& weld) {
        return !weld.sightings.empty() && weld.sightings.front().run == 0;
      });
  return anchor == ledger.welds.end() ? 0 : static_cast<std::size_t>(anchor - ledger.welds.begin());
}

bool share_a_run(const LedgerWeld& one, const LedgerWeld& other) {
  return std::any_of(
      one.sightings.begin(), one.sightings.end(), [&other](const LedgerSighting& mine) {
        return std::any_of(other.sightings.begin(), other.sightings.end(),
                           [&mine](const LedgerSighting& its) { return its.run == mine.run; });
      });
}

/// The welds by rising x, but those that one run saw in the order in which it saw them: that much
/// is certain, however little a sighting is worth.
std::vector<std::size_t> order_of(const WeldLedger& ledger, const std::vector<double>& x) {
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t k = 1; k < order.size(); ++k) {
    for (std::size_t j = k; j > 0 && x[order[j]] < x[order[j - 1]] &&
                            !share_a_run(ledger.welds[order[j]], ledger.welds[order[j - 1]]);
         --j) {
      std::swap(order[j], order[j - 1]);
    }
  }
  return order;
}

}  // namespace

void adjust(WeldLedger& ledger, const LedgerParameters& parameters) {
  const std::vector<Distance> observed =
      distances(ledger, parameters.length_noise * parameters.length_noise);
  std::size_t bandwidth = 1;
  for (const Distance& distance : observed) {
    bandwidth = std::max(bandwidth, distance.to - distance.from);
  }
  const std::size_t size = ledger.welds.size();
  const std::size_t anchor = find_anchor(ledger);
  const LedgerWeld& origin = ledger.welds[anchor];
  const double origin_sigma = origin.sightings.empty()
                                  ? origin.standard_deviation
                                  : origin.sightings.front().standard_deviation;
  std::vector<double> x(size);
  for (std::size_t k = 0; k < size; ++k) {
    x[k] = ledger.welds[k].chainage;
  }
  const std::vector<double> start = x;
  std::vector<double> weights;
  for (const Distance& distance : observed) {
    weights.push_back(1.0 / distance.variance);
  }
  BandedInformation information(size, bandwidth);
  std::vector<double> scales;
  const auto improve = [&] {
    scales = estimate_scales(observed, weights, x, ledger.runs.size());
    information = BandedInformation(size, bandwidth);
    // Corrections to x, not x itself, lose no digits to 20 km of pipe.
    information.observe(anchor, start[anchor] - x[anchor], 1.0 / (origin_sigma * origin_sigma));
    for (std::size_t k = 0; k < size; ++k) {
      information.observe(k, start[k] - x[k], kHold);
    }
    for (std::size_t e = 0; e < observed.size(); ++e) {
      const Distance& distance = observed[e];
      information.observe_difference(
          distance.from, distance.to,
          distance.length / scales[distance.run] - (x[distance.to] - x[distance.from]), weights[e]);
    }
    const std::vector<double> correction = information.solve();
    for (std::size_t k = 0; k < size; ++k) {
      x[k] += correction[k];
    }
  };
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    improve();
    const std::vector<double> misfit = misfits(observed, scales, x);
    for (std::size_t e = 0; e < observed.size(); ++e) {
      weights[e] = std::min(1.0, kHuberTuning / misfit[e]) / observed[e].variance;
    }
  }
  const std::vector<double> apart = disagreements(observed, misfits(observed, scales, x), size);
  for (std::size_t e = 0; e < observed.size(); ++e) {
    weights[e] = std::min(weights[e], 1.0 / (observed[e].variance * apart[e] * apart[e]));
  }
  improve();
  const double runs = static_cast<double>(std::max<std::size_t>(1, ledger.runs.size()));
  const double scale_variance = parameters.scale_sigma * parameters.scale_sigma / runs;
  const std::vector<std::size_t> order = order_of(ledger, x);
  std::vector<LedgerWeld> ordered;
  for (std::size_t k = 0; k < size; ++k) {
    const std::size_t i = order[k];
    LedgerWeld weld = std::move(ledger.welds[i]);
    const double away = x[i] - x[anchor];
    weld.chainage = ordered.empty() ? x[i] : std::max(x[i], ordered.back().chainage + kApart);
    weld.standard_deviation =
        std::sqrt(information.covariance(i, i) + scale_variance * away * away);
    if (k + 1 < size) {
      const std::size_t j = order[k + 1];
      const double length = x[j] - x[i];
      const auto [first, second] = std::minmax(i, j);
      // Beyond the band two welds are as good as independent.
      const double common =
          second - first <= bandwidth ? information.covariance(first, second) : 0.0;
      const double variance =
          information.covariance(i, i) + information.covariance(j, j) - 2.0 * common;
      weld.joint_standard_deviation =
          std::sqrt(std::max(variance, 0.0) + scale_variance * length * length);
    }
    ordered.push_back(std::move(weld));
  }
  for (std::size_t k = 0; k + 1 < size; ++k) {
    ordered[k].joint_length = ordered[k + 1].chainage - ordered[k].chainage;
  }
  if (size > 0) {
    ordered.back().joint_length = std::numeric_limits<double>::quiet_NaN();
    ordered.back().joint_standard_deviation = std::numeric_limits<double>::quiet_NaN();
  }
  ledger.welds = std::move(ordered);
}

}  // namespace pipescout::odometry
