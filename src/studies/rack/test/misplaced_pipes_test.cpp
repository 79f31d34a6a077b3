// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/misplaced_pipes.hpp"

#include <gtest/gtest.h>

#include <array>

#include "pipescout/rack_study/paper_flight.hpp"

namespace pipescout::rack_study {
namespace {

class MisplacedPipesIn : public ::testing::TestWithParam<World> {};

TEST_P(MisplacedPipesIn, AreFoundAsInFigure8) {
  MisplacedPipesSettings settings;
  settings.rack = parallel_rack(4);
  settings.world = GetParam();
  settings.stated_deviation = 0.2;
  settings.duration = 0.2;
  constexpr std::array kFile{0.0, 0.05, 0.15, 0.20};  // m
  const auto trial = try_misplaced_pipes(settings, kFile, 1);
  ASSERT_EQ(trial.frames.size(), 5U);
  ASSERT_TRUE(trial.frames.back().has_pose);
  EXPECT_LT(trial.largest_offset_error, 0.02);
  const auto score = score_misplaced_pipes({&trial, 1});
  EXPECT_EQ(score.silent_wrong, 0U);
  EXPECT_EQ(score.images_covered, score.images_with_pose);
}

TEST_P(MisplacedPipesIn, AreDrawnTheSameForASeed) {
  MisplacedPipesSettings settings;
  settings.rack = parallel_rack(3);
  settings.world = GetParam();
  settings.duration = 0.08;
  const auto once = try_misplaced_pipes(settings, 2, 7);
  const auto twice = try_misplaced_pipes(settings, 2, 7);
  ASSERT_EQ(once.size(), 2U);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].frames.back().error, twice[i].frames.back().error);
  }
}

INSTANTIATE_TEST_SUITE_P(Worlds, MisplacedPipesIn,
                         ::testing::Values(World::kRayCaster, World::kMesh));

}  // namespace
}  // namespace pipescout::rack_study
