// SPDX-License-Identifier: Apache-2.0
#include "weld_proposals.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace pipescout::odometry::alignment {
namespace {

/// Of a pipe of 40 joints, the welds from `first` on.
WeldSequence part(std::size_t first, std::size_t count) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> length(12.0, 0.5);
  WeldSequence sequence;
  double chainage = 0.0;
  for (std::size_t k = 0; k < first + count; ++k) {
    if (k >= first) {
      sequence.chainage.push_back(chainage);
      sequence.variance.push_back(1e-4);
      sequence.index.push_back(k - first);
    }
    chainage += length(engine);
  }
  return sequence;
}

/// Every proposal is a pair of welds that there are; the best is of one weld.
void check(std::size_t first_a, std::size_t count_a, std::size_t first_b, std::size_t count_b,
           const WeldAlignmentParameters& parameters = {}) {
  const WeldSequence a = part(first_a, count_a);
  const WeldSequence b = part(first_b, count_b);
  const AlignmentModel model(parameters, a, b);
  const auto proposals = propose(model, 1000);
  ASSERT_FALSE(proposals.empty());
  for (const Proposal& proposal : proposals) {
    EXPECT_LT(proposal.a, a.size());
    EXPECT_LT(proposal.b, b.size());
  }
  EXPECT_EQ(proposals.front().a + first_a, proposals.front().b + first_b);
}

TEST(WeldProposals, AreOfWeldsThatThereAre) {
  check(0, 20, 0, 20);
  check(0, 30, 12, 20);  // A begins before B: its stretches begin late
  check(12, 20, 0, 30);
  check(5, 12, 0, 40);
  check(0, 40, 5, 12);
}

TEST(WeldProposals, AreOfWeldsThatThereAreWithinAnOffset) {
  check(0, 30, 12, 20, {.offset = 0.0, .offset_tolerance = 60.0});
  check(12, 20, 0, 30, {.offset = 0.0, .offset_tolerance = 60.0});
}

}  // namespace
}  // namespace pipescout::odometry::alignment
