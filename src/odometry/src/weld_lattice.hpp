// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "weld_alignment_model.hpp"
#include "weld_proposals.hpp"

namespace pipescout::odometry::alignment {

struct Pair {
  std::size_t a = 0;
  std::size_t b = 0;
  double probability = 1.0;
};

/// The likeliest path through one proposal.
struct Trace {
  double score = 0.0;
  std::vector<Pair> path;  // both rise strictly; holds the proposal
};

/// Follows the proposal to both ends, until the lists end or agree no more. `mirror` is the model
/// of the mirrored lists.
[[nodiscard]] Trace trace(const AlignmentModel& model, const AlignmentModel& mirror,
                          const Proposal& proposal);

struct Posterior {
  double log_evidence = 0.0;  // log of the summed weight of all paths in the band
  std::vector<Pair> pairs;    // of notable probability, by a, then b
};

/// All paths in a band of a few joints around `path`, wherever they begin and end.
[[nodiscard]] Posterior posterior(const AlignmentModel& model, const std::vector<Pair>& path);

/// Whether the pair lies in the band around the path that `posterior` looks at.
[[nodiscard]] bool in_band(const AlignmentModel& model, const std::vector<Pair>& path,
                           std::size_t a, std::size_t b);

}  // namespace pipescout::odometry::alignment
