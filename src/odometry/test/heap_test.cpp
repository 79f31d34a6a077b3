// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "heap_guard.hpp"
#include "pipescout/odometry/consensus_fusion.hpp"

namespace pipescout::odometry {
namespace {

using pipescout::test::HeapGuard;

TEST(HeapGuard, SeesEveryKindOfAllocation) {
  const HeapGuard guard;
  const auto by_new = std::make_unique<std::vector<int>>(100);  // two
  EXPECT_EQ(guard.allocations(), 2U);
  const Eigen::VectorXd by_eigen = Eigen::VectorXd::Zero(100);
  EXPECT_EQ(guard.allocations(), 3U);
  struct alignas(64) Aligned {
    char bytes[64];
  };
  const auto by_aligned_new = std::make_unique<Aligned>();
  EXPECT_EQ(guard.allocations(), 4U);
}

TEST(Heap, FusionAllocatesNothing) {
  for (std::size_t m = kMinOdometers; m <= kMaxOdometers; ++m) {
    for (const auto weighting : {Weighting::kMaximumLikelihood, Weighting::kPaperEquation13}) {
      for (const auto rule : {SupportRule::kMajority, SupportRule::kMutualMajority}) {
        const ConsensusFusion fusion(
            {.weighting = weighting, .support_rule = rule, .offsets = std::vector<double>(m, 0.1)});
        std::array<OdometerReading, kMaxOdometers> agreeing;
        agreeing.fill({.distance = 1.0, .standard_deviation = 0.05});
        auto scattered = agreeing;
        for (std::size_t i = 0; i < m; ++i) {
          scattered[i].distance += static_cast<double>(i);
        }
        auto broken = agreeing;
        broken[0] = {};

        std::size_t allocations = 0;
        FusionStatus agreed{};
        FusionStatus disagreed{};
        {
          const HeapGuard guard;
          agreed = fusion.fuse(std::span(agreeing).first(m)).status;
          disagreed = fusion.fuse(std::span(scattered).first(m)).status;
          static_cast<void>(fusion.fuse(std::span(broken).first(m)));
          allocations = guard.allocations();
        }
        EXPECT_EQ(allocations, 0U) << "m = " << m;
        EXPECT_EQ(agreed, FusionStatus::kOk);
        EXPECT_EQ(disagreed, FusionStatus::kNoConsensus);
      }
    }
  }
}

}  // namespace
}  // namespace pipescout::odometry
