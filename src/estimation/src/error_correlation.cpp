// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/error_correlation.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/estimation/absolute_source_watch.hpp"

namespace pipescout::estimation {
namespace {

/// Innovations that the variances are of, and squares that they are of at least.
constexpr double kMemory = 4096;
constexpr double kLeastMemory = 16;
constexpr double kFewest = 8;  // before what was learnt counts
/// Squares beyond it count as that much: an outlier says nothing of how long errors stay alike.
constexpr double kLargestShare = 9;

/// Variance of the mean of `count` errors, times `count` and over that of one; `kept`: their
/// correlation from one to the next.
double growth(double kept, double count) {
  const double lost = 1 - kept;
  return (1 + kept) / lost - 2 * kept * (1 - std::pow(kept, count)) / (count * lost * lost);
}

}  // namespace

void ErrorCorrelation::add(double time, const Eigen::Vector2d& innovation) noexcept {
  constexpr double kGap = 4;  // spacings: what is after it is not of one mean with what is before
  constexpr double kUsual = 0.05;  // rate of the mean spacing
  if (!(time > newest_) || !innovation.allFinite()) {
    return;
  }
  const double step = time - newest_;
  newest_ = time;
  if (std::isfinite(step)) {
    if (spacing_ > 0 && step > kGap * spacing_) {
      for (Level& level : levels_) {
        level.has_first = false;
      }
    } else {
      spacing_ += spacing_ > 0 ? kUsual * (step - spacing_) : step;
    }
  }
  Eigen::Vector2d mean = innovation;
  double memory = kMemory;
  for (Level& level : levels_) {
    double square = 0.5 * mean.squaredNorm();
    if (level.count >= kFewest && square > kLargestShare * level.square) {
      mean *= std::sqrt(kLargestShare * level.square / square);
      square = kLargestShare * level.square;
    }
    level.count = std::min(level.count + 1, memory);
    memory = std::max(0.5 * memory, kLeastMemory);
    level.square += (square - level.square) / level.count;
    level.has_first = !level.has_first;
    if (level.has_first) {
      level.first = mean;
      return;
    }
    mean = 0.5 * (level.first + mean);
  }
}

double ErrorCorrelation::time(double shortest, double longest) const noexcept {
  if (!(longest > shortest) || !(spacing_ > 0) || !(levels_[0].square > 0)) {
    return longest;
  }
  // The worst of what may be, of a share of the errors that stays alike for some time.
  constexpr int kTimes = 20;
  constexpr double kFiner = 0.7;
  double factor = 0;
  for (int i = 0; i < kTimes; ++i) {
    factor = std::max(factor, possible_factor(longest * std::pow(kFiner, i)).value_or(0));
  }
  if (factor == 0) {
    return longest;
  }
  if (!(factor > 1)) {
    return shortest;
  }
  return std::clamp(0.5 * spacing_ / std::atanh(1 / factor), shortest, longest);
}

std::optional<double> ErrorCorrelation::possible_factor(double correlation_time) const noexcept {
  constexpr double kSigmas = 1.5;
  constexpr double kContradicted = 2.5;  // sigmas
  const double kept = std::exp(-spacing_ / correlation_time);
  double seen = 1;
  double size = 1;
  double least = 0;  // of the share
  double most = 1;
  for (std::size_t i = 1; i < kLevels && levels_[i].count >= kFewest; ++i) {
    size *= 2;
    const double here = size * levels_[i].square / levels_[0].square;
    // What rises and falls again has been followed by the filter meanwhile.
    seen = std::max(seen, here);
    const double deviation = 1 / std::sqrt(levels_[i].count);
    const double by_share = growth(kept, size) - 1;
    most = std::min(most, (seen * (1 + kSigmas * deviation) - 1) / by_share);
    least = std::max(least, (here * (1 - kContradicted * deviation) - 1) / by_share);
  }
  if (least > most) {
    return std::nullopt;
  }
  return 1 + most * (covariance_factor(correlation_time, spacing_) - 1);
}

}  // namespace pipescout::estimation
