// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/weld_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "pipescout/validation/check.hpp"
#include "weld_alignment_model.hpp"
#include "weld_search.hpp"

namespace pipescout::odometry {
namespace {

using validation::refuse;
using validation::require;

using alignment::Pair;
using alignment::Posterior;
using alignment::Search;
using alignment::WeldSequence;

constexpr std::size_t kFewestWelds = 3;
// Evidence beyond chance below which nothing has been found: gaps and the free ratio of the
// odometers lift the best of many places some nats above the logarithm of their number.
constexpr double kLeastMargin = 10.0;

/// The welds of one list that have no partner. `to_other` maps their chainage to the other list.
std::vector<UnmatchedWeld> unmatched(std::span<const WeldPosition> own,
                                     const WeldSequence& sequence,
                                     const std::vector<double>& matched,
                                     const std::vector<double>& best, const ChainageMap& to_other,
                                     double first_other, double last_other) {
  const double margin = 0.5 * (sequence.chainage.back() - sequence.chainage.front()) /
                        static_cast<double>(sequence.size() - 1);
  std::vector<UnmatchedWeld> result;
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    if (matched[k] == 0.0) {
      const std::size_t index = sequence.index[k];
      const double there = to_other.map(own[index].chainage).chainage;
      result.push_back(
          {.index = index,
           .within_overlap = there >= first_other - margin && there <= last_other + margin,
           .best_probability = best[k]});
    }
  }
  std::sort(result.begin(), result.end(), [](const UnmatchedWeld& one, const UnmatchedWeld& next) {
    return one.index < next.index;
  });
  return result;
}

ChainageMap make_map(std::span<const WeldPosition> a, std::span<const WeldPosition> b,
                     const std::vector<WeldMatch>& matches,
                     const WeldAlignmentParameters& parameters) {
  std::vector<ChainageKnot> knots;
  for (const WeldMatch& match : matches) {
    knots.push_back({.from = a[match.a].chainage,
                     .to = b[match.b].chainage,
                     .standard_deviation =
                         std::hypot(a[match.a].standard_deviation, b[match.b].standard_deviation)});
  }
  return ChainageMap(std::move(knots), {.length_noise = parameters.length_noise,
                                        .scale_sigma = parameters.scale_sigma});
}

/// Matches, map and what is left over. `place`: probability that the lists meet here at all.
void fill(WeldAlignment& result, std::span<const WeldPosition> a, std::span<const WeldPosition> b,
          const WeldSequence& sequence_a, const WeldSequence& sequence_b,
          const Posterior& posterior, double place, const WeldAlignmentParameters& parameters) {
  std::vector<double> matched_a(sequence_a.size(), 0.0);
  std::vector<double> matched_b(sequence_b.size(), 0.0);
  std::vector<double> best_a(sequence_a.size(), 0.0);
  std::vector<double> best_b(sequence_b.size(), 0.0);
  for (const Pair& pair : posterior.pairs) {
    const double probability = pair.probability * place;
    best_a[pair.a] = std::max(best_a[pair.a], probability);
    best_b[pair.b] = std::max(best_b[pair.b], probability);
    // At most one partner of a weld is more likely than not, and such pairs never cross.
    if (probability > parameters.accept_probability) {
      matched_a[pair.a] = matched_b[pair.b] = probability;
      result.matches.push_back({.a = sequence_a.index[pair.a],
                                .b = sequence_b.index[pair.b],
                                .probability = probability});
    }
  }
  if (result.matches.empty()) {
    result.status = AlignmentStatus::kNoOverlap;
  }
  result.a_to_b = make_map(a, b, result.matches, parameters);
  for (std::size_t k = 1; k < result.matches.size(); ++k) {
    result.matches[k].residual = (result.reversed ? -1.0 : 1.0) * result.a_to_b.slip(k - 1);
  }
  const auto ends = [](std::span<const WeldPosition> welds, const WeldSequence& sequence) {
    return std::minmax(welds[sequence.index.front()].chainage,
                       welds[sequence.index.back()].chainage);
  };
  const std::pair<double, double> ends_a = ends(a, sequence_a);
  const std::pair<double, double> ends_b = ends(b, sequence_b);
  result.only_a =
      unmatched(a, sequence_a, matched_a, best_a, result.a_to_b, ends_b.first, ends_b.second);
  result.only_b = unmatched(b, sequence_b, matched_b, best_b, result.a_to_b.inverse(), ends_a.first,
                            ends_a.second);
}

}  // namespace

void WeldAlignmentParameters::validate() const {
  if (direction != AlignmentDirection::kForward && direction != AlignmentDirection::kReversed &&
      direction != AlignmentDirection::kEither) {
    refuse("direction: ", static_cast<int>(direction), " is outside {0, 1, 2}");
  }
  const auto probability = [](const char* field, double value) {
    require(field, value, value > 0.0 && value < 0.5, "(0, 0.5)");
  };
  const auto count = [](const char* field, std::size_t value) {
    if (value < 1 || value > 1000) {
      refuse(field, ": ", value, " is outside [1, 1000]");
    }
  };
  probability("missed_probability", missed_probability);
  probability("spurious_probability", spurious_probability);
  probability("outage_probability", outage_probability);
  probability("slip_probability", slip_probability);
  require("outage_welds", outage_welds, outage_welds >= 1.0 && outage_welds <= 1e6, "[1, 1e6]");
  require("scale_sigma", scale_sigma, scale_sigma > 0.0 && scale_sigma <= 0.2, "(0, 0.2]");
  require("scale_drift", scale_drift, scale_drift >= 0.0 && scale_drift <= 0.2, "[0, 0.2]");
  require("length_noise", length_noise, length_noise >= 0.0 && length_noise <= 1.0, "[0, 1]");
  require("slip_scale", slip_scale, slip_scale > 0.0 && slip_scale <= 10.0, "(0, 10]");
  require("largest_slip", largest_slip, largest_slip > 0.0 && largest_slip <= 100.0, "(0, 100]");
  require("offset", offset, true, "(-infinity, infinity)");
  if (!(offset_tolerance > 0.0)) {
    refuse("offset_tolerance: ", offset_tolerance, " is outside (0, infinity]");
  }
  require("accept_probability", accept_probability,
          accept_probability >= 0.5 && accept_probability < 1.0, "[0.5, 1)");
  count("longest_gap", longest_gap);
  count("proposals", proposals);
}

WeldAlignment align_welds(std::span<const WeldPosition> a, std::span<const WeldPosition> b,
                          const WeldAlignmentParameters& parameters) {
  parameters.validate();
  WeldAlignment result;
  const WeldSequence sequence_a = alignment::usable(a, result.unusable_a);
  const WeldSequence sequence_b = alignment::usable(b, result.unusable_b);
  const auto list_all = [&](const WeldSequence& sequence, std::vector<UnmatchedWeld>& welds) {
    for (const std::size_t index : sequence.index) {
      welds.push_back({.index = index});
    }
  };
  if (sequence_a.size() < kFewestWelds || sequence_b.size() < kFewestWelds) {
    list_all(sequence_a, result.only_a);
    list_all(sequence_b, result.only_b);
    return result;
  }

  const WeldSequence turned = alignment::mirrored(sequence_b);
  std::optional<Search> forward;
  std::optional<Search> reversed;
  if (parameters.direction != AlignmentDirection::kReversed) {
    forward.emplace(parameters, sequence_a, sequence_b);
  }
  if (parameters.direction != AlignmentDirection::kForward) {
    reversed.emplace(parameters, sequence_a, turned);
  }
  if (forward && reversed) {
    // The one that promises more first: when it finds the place, the other need not look far.
    const bool forward_first = forward->promise() >= reversed->promise();
    const bool found = (forward_first ? forward : reversed)->run(false);
    (forward_first ? reversed : forward)->run(found);
    result.reversed = reversed->best_score() > forward->best_score();
  } else {
    result.reversed = reversed.has_value();
    (reversed ? reversed : forward)->run(false);
  }
  const Search& best = result.reversed ? *reversed : *forward;
  const std::optional<Search>& other = result.reversed ? forward : reversed;
  result.score = best.best_score();
  result.other_score =
      std::max(best.other_score(), other ? other->best_score() : best.other_score());
  const double chance = alignment::log_places(parameters, sequence_a, sequence_b);
  if (!(result.score >= chance + kLeastMargin)) {
    result.status = AlignmentStatus::kNoOverlap;
    result.reversed = false;
    list_all(sequence_a, result.only_a);
    list_all(sequence_b, result.only_b);
    return result;
  }
  result.status = AlignmentStatus::kOk;
  // This place against the best other one, and against none: prior odds are even.
  const double place =
      1.0 / (1.0 + std::exp(result.other_score - result.score) + std::exp(chance - result.score));
  fill(result, a, b, sequence_a, result.reversed ? turned : sequence_b, best.posterior(), place,
       parameters);
  return result;
}

const char* to_string(AlignmentStatus status) noexcept {
  switch (status) {
    case AlignmentStatus::kOk:
      return "ok";
    case AlignmentStatus::kTooFewWelds:
      return "too few welds";
    case AlignmentStatus::kNoOverlap:
      return "no overlap";
  }
  return "unknown";
}

}  // namespace pipescout::odometry
