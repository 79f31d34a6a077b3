// SPDX-License-Identifier: Apache-2.0
#include "weld_search.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::odometry::alignment {
namespace {

constexpr double kPlainMargin = 25.0;  // beyond chance: no further proposals need be looked at
constexpr std::size_t kProposalsPerTrace = 32;

}  // namespace

double log_places(const WeldAlignmentParameters& parameters, const WeldSequence& a,
                  const WeldSequence& b) {
  const auto count_b = static_cast<double>(b.size());
  const double joint = (b.chainage.back() - b.chainage.front()) / (count_b - 1.0);
  return std::log(static_cast<double>(a.size())) +
         std::log(std::min(count_b, 1.0 + 2.0 * parameters.offset_tolerance / joint));
}

Search::Search(const WeldAlignmentParameters& parameters, const WeldSequence& a,
               const WeldSequence& b)
    : mirror_a_(mirrored(a)),
      mirror_b_(mirrored(b)),
      model_(parameters, a, b),
      mirror_(parameters, mirror_a_, mirror_b_),
      proposals_(propose(model_, kProposalsPerTrace * parameters.proposals)),
      plain_score_(log_places(parameters, a, b) + kPlainMargin) {}

double Search::promise() const noexcept {
  return proposals_.empty() ? 0.0 : proposals_.front().score;
}

bool Search::run(bool found) {
  std::vector<Trace> traces;
  for (const Proposal& proposal : proposals_) {
    if (found && traces.size() >= model_.parameters().proposals) {
      break;
    }
    // Neighbouring diagonals often lead to the same path.
    const bool known = std::any_of(traces.begin(), traces.end(), [&](const Trace& trace) {
      return in_band(model_, trace.path, proposal.a, proposal.b);
    });
    if (!known) {
      traces.push_back(trace(model_, mirror_, proposal));
      found = found || traces.back().score >= plain_score_;
    }
  }
  if (traces.empty()) {
    return false;
  }
  const auto best = std::max_element(
      traces.begin(), traces.end(),
      [](const Trace& one, const Trace& other) { return one.score < other.score; });
  best_score_ = best->score;
  best_path_ = best->path;
  for (const Trace& trace : traces) {
    // Two traces may have grown into one another.
    const bool same = std::any_of(trace.path.begin(), trace.path.end(), [&](const Pair& pair) {
      return in_band(model_, best_path_, pair.a, pair.b);
    });
    if (!same) {
      other_score_ = std::max(other_score_, trace.score);
    }
  }
  return best_score_ >= plain_score_;
}

}  // namespace pipescout::odometry::alignment
