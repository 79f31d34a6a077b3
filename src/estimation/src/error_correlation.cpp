// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/error_correlation.hpp"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

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

double ErrorCorrelation::shortest_time(double sigmas) const noexcept {
  constexpr double kLongest = 1000;  // s, as SourceWatchParameters have it
  constexpr double kFiner = 1.2;
  constexpr double kFewestMeans = 16;
  const double one = std::max(levels_[0].square, 1.0);
  double shortest = kLongest;
  for (double candidate = 0.25 * spacing_; candidate < kLongest; candidate *= kFiner) {
    const double kept = std::exp(-spacing_ / candidate);
    double share = 0;  // of the errors that is correlated for so long
    double size = 1;
    for (std::size_t i = 1; i < kLevels && levels_[i].count >= kFewestMeans; ++i) {
      size *= 2;
      const double grown = size * levels_[i].square / one;
      const double certain = grown * (1 - sigmas / std::sqrt(levels_[i].count));
      share = std::max(share, (certain - 1) / (growth(kept, size) - 1));
    }
    if (share == 0) {
      return 0;
    }
    if (share <= 1) {
      const double factor = 1 + share * (covariance_factor(candidate, spacing_) - 1);
      shortest = std::min(shortest, 0.5 * spacing_ / std::atanh(1 / factor));
    }
  }
  return shortest;
}

std::optional<SeenCorrelation> ErrorCorrelation::seen() const noexcept {
  constexpr double kSigmas = 2;
  constexpr double kNone = 0.5;  // spacings: errors that are alike for less are as good as white
  if (!(levels_[0].count >= kFewestSeen) || !(spacing_ > 0)) {
    return std::nullopt;
  }
  const double least = shortest_time(kSigmas);
  return SeenCorrelation{.about = shortest_time(0), .least = least > kNone * spacing_ ? least : 0};
}

bool CorrelationFinding::is_beyond_stated() const noexcept {
  constexpr double kClearly = 1.5;  // within it both count for the same, as far as it can be known
  return seen && seen->least > longest && seen->about > kClearly * longest;
}

std::string correlation_text(std::string_view source, const CorrelationFinding& finding) {
  constexpr double kMuchShorter = 0.5;
  const auto two_digits = [](double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(std::max(value, 0.1))) - 1);
    return std::round(value / unit) * unit;
  };
  std::ostringstream text;
  text.imbue(std::locale::classic());
  const bool on_line = finding.shortest < finding.longest;
  if (!finding.seen) {
    return {};
  }
  if (finding.is_beyond_stated()) {
    text << "errors of " << source << " seem correlated over " << two_digits(finding.seen->about)
         << " s or more, told " << (on_line ? "at most " : "") << finding.longest << " s; set "
         << source << ".correlation_time";
  } else if (on_line) {
    text << "errors of " << source << " are taken as correlated over " << two_digits(finding.used)
         << " s, found on line between " << finding.shortest << " and " << finding.longest << " s";
  } else if (finding.most < kMuchShorter * finding.longest) {
    text << "errors of " << source << " seem correlated over " << two_digits(finding.most)
         << " s at most, told " << finding.longest << " s, which is on the safe side";
  } else {
    text << "errors of " << source << " show no longer correlation than told, " << finding.longest
         << " s; what lasts for longer than the state takes to follow does not show";
  }
  return text.str();
}

}  // namespace pipescout::estimation
