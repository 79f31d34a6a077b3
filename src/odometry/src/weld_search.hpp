// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "weld_alignment_model.hpp"
#include "weld_lattice.hpp"
#include "weld_proposals.hpp"

namespace pipescout::odometry::alignment {

/// Log of the number of places where two lists may meet: about what the best of them scores by
/// chance (Karlin and Altschul, PNAS 87, 1990, for ungapped stretches). Fewer when the offset of
/// the chainages is known.
[[nodiscard]] double log_places(const WeldAlignmentParameters& parameters, const WeldSequence& a,
                                const WeldSequence& b);

/// Where the lists meet, in one direction.
class Search {
 public:
  /// Proposes. Keeps references to all three.
  Search(const WeldAlignmentParameters& parameters, const WeldSequence& a, const WeldSequence& b);
  Search(const Search&) = delete;
  Search& operator=(const Search&) = delete;

  /// Of the best proposal.
  [[nodiscard]] double promise() const noexcept;

  /// Traces the proposals: as many as the parameters ask for when the place is plain (or `found`
  /// says that it is already), else all. True when it is plain.
  bool run(bool found);

  /// Scores of the best trace, and of the best one that leads through other places.
  [[nodiscard]] double best_score() const noexcept { return best_score_; }
  [[nodiscard]] double other_score() const noexcept { return other_score_; }

  /// Around the best trace. Not checked: there is one.
  [[nodiscard]] Posterior posterior() const { return alignment::posterior(model_, best_path_); }

 private:
  WeldSequence mirror_a_;
  WeldSequence mirror_b_;
  AlignmentModel model_;
  AlignmentModel mirror_;
  std::vector<Proposal> proposals_;
  double plain_score_;
  double best_score_ = -std::numeric_limits<double>::infinity();
  double other_score_ = -std::numeric_limits<double>::infinity();
  std::vector<Pair> best_path_;
};

}  // namespace pipescout::odometry::alignment
