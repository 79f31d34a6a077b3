// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/track_witness.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace pipescout::estimation {
namespace {

constexpr std::size_t kFewest = 10;  // pairs before what was learnt counts
/// What the mean is of: so many spans, and so many seconds at least. What drifts off slowly is not
/// to be what is usual before it is noticed.
constexpr double kMemorySpans = 16;
constexpr double kLeastMemory = 100;  // s
/// Squares beyond it count as that much: one jump is not what is usual.
constexpr double kLargestShare = 9;

double span_length(std::size_t i) {
  return std::ldexp(1.0, static_cast<int>(i));
}

/// m^2, the sum over both axes.
double parted(const TrackPair& from, const TrackPair& to, double yaw) {
  const Eigen::Vector2d reckoned =
      Eigen::Rotation2Dd(yaw) * (to.reckoned - from.reckoned).head<2>();
  return ((to.measured - from.measured).head<2>() - reckoned).squaredNorm();
}

}  // namespace

void TrackWitness::learn(const TrackPair& pair, double yaw) noexcept {
  if (pair.time <= newest_) {
    return;
  }
  const double step = std::isfinite(newest_) ? pair.time - newest_ : 0;
  newest_ = pair.time;
  for (std::size_t i = 0; i < kSpans; ++i) {
    Span& span = spans_[i];
    if (!span.next) {
      span.next = pair;
      continue;
    }
    if (pair.time - span.next->time >= span_length(i)) {
      span.anchor = span.next;
      span.next = pair;
    }
    if (!span.anchor || pair.time - span.anchor->time > 2 * span_length(i) + 1) {
      continue;
    }
    double square = 0.5 * parted(*span.anchor, pair, yaw);
    if (span.count >= kFewest) {
      square = std::min(square, kLargestShare * span.square);
    }
    ++span.count;
    const double memory = std::max(kLeastMemory, kMemorySpans * span_length(i));
    span.square +=
        (square - span.square) * std::max(1 / static_cast<double>(span.count), step / memory);
  }
}

double TrackWitness::parts_by(double elapsed) const noexcept {
  double known = 0;
  double length = 1;
  for (std::size_t i = 0; i < kSpans; ++i) {
    if (spans_[i].count >= kFewest) {
      known = std::max(known, std::sqrt(spans_[i].square));
      length = 2 * span_length(i);
      if (length >= elapsed) {
        return known;
      }
    }
  }
  return known * std::max(1.0, elapsed / length);
}

std::optional<bool> TrackWitness::bears_out(const TrackPair& pair, double yaw, double gate,
                                            double share, double floor) const noexcept {
  std::optional<bool> result;
  for (const Span& span : spans_) {
    const std::optional<TrackPair>& from = span.anchor ? span.anchor : span.next;
    if (!from || from->time >= pair.time) {
      continue;
    }
    const double drift =
        std::max({floor, share * (pair.way - from->way), parts_by(pair.time - from->time)});
    const double variance =
        pair.deviation * pair.deviation + from->deviation * from->deviation + drift * drift;
    if (parted(*from, pair, yaw) > gate * variance) {
      return false;
    }
    result = true;
  }
  return result;
}

}  // namespace pipescout::estimation
