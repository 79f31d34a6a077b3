// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/chainage_map.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::odometry {
namespace {

using validation::refuse;
using validation::require;

// Joints on either side that the local ratio of the odometers is taken over: long enough to average
// the noise of single joints, short enough to follow wear.
constexpr std::size_t kJointsAround = 5;

void check_not_negative(const char* field, double value) {
  require(field, value, value >= 0.0, "[0, infinity)");
}

void check(std::span<const ChainageKnot> knots) {
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const ChainageKnot& knot = knots[k];
    if (!std::isfinite(knot.from) || !std::isfinite(knot.to)) {
      refuse("knots[", k, "]: ", knot.from, " -> ", knot.to, " is not finite");
    }
    check_not_negative("standard_deviation", knot.standard_deviation);
    if (k == 0) {
      continue;
    }
    if (!(knot.from > knots[k - 1].from)) {
      refuse("knots[", k, "].from: ", knot.from, " is not above ", knots[k - 1].from);
    }
    const bool rises = knots[1].to > knots[0].to;
    const double step = knot.to - knots[k - 1].to;
    if (!(rises ? step > 0.0 : step < 0.0)) {
      refuse("knots[", k, "].to: ", knot.to, " does not continue from ", knots[k - 1].to);
    }
  }
}

}  // namespace

void ChainageMapParameters::validate() const {
  check_not_negative("length_noise", length_noise);
  check_not_negative("scale_sigma", scale_sigma);
}

ChainageMap::ChainageMap(std::vector<ChainageKnot> knots, ChainageMapParameters parameters)
    : knots_(std::move(knots)), parameters_(parameters) {
  parameters_.validate();
  check(knots_);
}

double ChainageMap::ratio_around(std::size_t segment, bool with_itself) const noexcept {
  const std::size_t first = segment - std::min(segment, kJointsAround);
  const std::size_t last = std::min(segment + kJointsAround + 1, knots_.size() - 1);
  double from = knots_[last].from - knots_[first].from;
  double to = knots_[last].to - knots_[first].to;
  if (!with_itself && last - first > 1) {
    from -= knots_[segment + 1].from - knots_[segment].from;
    to -= knots_[segment + 1].to - knots_[segment].to;
  }
  return to / from;
}

double ChainageMap::slip(std::size_t segment) const noexcept {
  const double length = knots_[segment + 1].from - knots_[segment].from;
  return knots_[segment + 1].to - knots_[segment].to - ratio_around(segment, false) * length;
}

MappedChainage ChainageMap::map(double from) const noexcept {
  if (knots_.empty() || !std::isfinite(from)) {
    return {};
  }
  const double noise = parameters_.length_noise * parameters_.length_noise;
  if (knots_.size() == 1 || from < knots_.front().from || from > knots_.back().from) {
    const bool before = from < knots_.front().from;
    const ChainageKnot& end = before ? knots_.front() : knots_.back();
    const double ratio =
        knots_.size() == 1 ? 1.0 : ratio_around(before ? 0 : knots_.size() - 2, true);
    const double distance = from - end.from;
    const double scale = parameters_.scale_sigma * distance;
    return {.chainage = end.to + ratio * distance,
            .standard_deviation = std::sqrt(end.standard_deviation * end.standard_deviation +
                                            noise * std::abs(distance) + scale * scale),
            .between_welds = distance == 0.0};
  }
  const auto above = std::upper_bound(
      knots_.begin() + 1, knots_.end() - 1, from,
      [](double chainage, const ChainageKnot& knot) { return chainage < knot.from; });
  const ChainageKnot& next = *above;
  const ChainageKnot& previous = *(above - 1);
  const double length = next.from - previous.from;
  const double t = (from - previous.from) / length;
  const double slipped = slip(static_cast<std::size_t>(above - knots_.begin()) - 1);
  const double from_previous = (1.0 - t) * previous.standard_deviation;
  const double from_next = t * next.standard_deviation;
  const double variance = from_previous * from_previous + from_next * from_next +
                          (noise * length + slipped * slipped) * t * (1.0 - t);
  // std::lerp is exact at both ends and monotone between.
  return {.chainage = std::lerp(previous.to, next.to, t),
          .standard_deviation = std::sqrt(variance),
          .between_welds = true};
}

ChainageMap ChainageMap::inverse() const {
  ChainageMap inverse;
  inverse.parameters_ = parameters_;
  inverse.knots_.reserve(knots_.size());
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    const double ratio =
        knots_.size() == 1 ? 1.0 : std::abs(ratio_around(std::min(k, knots_.size() - 2), true));
    inverse.knots_.push_back({.from = knots_[k].to,
                              .to = knots_[k].from,
                              .standard_deviation = knots_[k].standard_deviation / ratio});
  }
  if (knots_.size() > 1 && knots_[1].to < knots_[0].to) {
    std::reverse(inverse.knots_.begin(), inverse.knots_.end());
  }
  return inverse;
}

}  // namespace pipescout::odometry
