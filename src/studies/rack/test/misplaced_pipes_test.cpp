// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/misplaced_pipes.hpp"

#include <gtest/gtest.h>

#include <array>

#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/rack_study/paper_flight.hpp"

namespace pipescout::rack_study {
namespace {

class MisplacedPipesIn : public ::testing::TestWithParam<World> {};

TEST_P(MisplacedPipesIn, AreFoundWhereTheFileIsRight) {
  MisplacedPipesSettings settings;
  settings.rack = parallel_rack(4);
  settings.world = GetParam();
  settings.duration = 0.2;
  constexpr std::array kFile{0.0, 0.0, 0.0, 0.0};  // m
  const auto trial = try_misplaced_pipes(settings, kFile, 5);
  ASSERT_EQ(trial.frames.size(), 5U);
  ASSERT_TRUE(trial.frames.back().has_pose);
  EXPECT_LT(trial.largest_offset_error, 0.02);
  const auto score = score_misplaced_pipes({&trial, 1});
  EXPECT_EQ(score.converged, 1U);
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

TEST(MisplacedPipesScore, CountsWrongPosesThatTheCovarianceDenies) {
  FrameScore right;
  right.has_pose = true;
  right.pose_nees = 6;
  FrameScore wrong = right;
  wrong.error.x() = 2 * kWrongPosition;
  FrameScore silent = wrong;
  silent.pose_nees = 100;
  const std::array<MisplacedPipesTrial, 3> trials{
      {{.frames = {right, silent, right}}, {.frames = {wrong}}, {.frames = {silent, {}}}}};
  const auto score = score_misplaced_pipes(trials);
  EXPECT_EQ(score.trials, 3U);
  EXPECT_EQ(score.converged, 1U);
  EXPECT_EQ(score.lost, 1U);
  EXPECT_EQ(score.silent_wrong, 2U);
  EXPECT_EQ(score.images_silent, 2U);
  EXPECT_EQ(score.images_with_pose, 5U);
  EXPECT_EQ(score.images_covered, 3U);
}

}  // namespace
}  // namespace pipescout::rack_study
