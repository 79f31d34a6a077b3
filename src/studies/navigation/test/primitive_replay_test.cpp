// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_study/primitive_replay.hpp"

#include <gtest/gtest.h>

namespace pipescout::navigation_study {
namespace {

TEST(PrimitiveReplay, TheVehicleEndsWhereThePrimitivesSay) {
  const auto lattice = navigation::generate_primitives(2.6, 0.3);
  const PrimitiveReplay replay = replay_primitives(lattice);
  EXPECT_EQ(replay.primitives, lattice.primitives.size());
  EXPECT_LT(replay.position, 0.01);
  EXPECT_LT(replay.heading, 0.0087);  // 0.5 degrees
  // One that says something else is seen.
  auto wrong = lattice;
  wrong.primitives.front().columns += 1;
  EXPECT_GT(replay_primitives(wrong).position, 0.1);
}

}  // namespace
}  // namespace pipescout::navigation_study
