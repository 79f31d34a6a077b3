// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipescout/rack_study/first_pose_trials.hpp"
#include "pipescout/rack_study/offset_run.hpp"
#include "pipescout/rack_study/paper_flight.hpp"
#include "pipescout/rack_study/table_one.hpp"

namespace pipescout::rack_study {
namespace {

constexpr std::uint64_t kSeed = 7;

TEST(PaperFlight, PassesTheWayPointsWithinTheGusts) {
  const auto model = parallel_rack(4);
  const auto flight = paper_flight(model, {}, kSeed);
  // 5.4 m at 0.4 m/s with ramps; the authors' own flight has 452 frames.
  EXPECT_GT(flight.size(), 400U);
  EXPECT_LT(flight.size(), 520U);
  const double middle = 0.5 * 4 * (6 + 8) * 0.0254;  // half of the summed diameters
  for (const Eigen::Vector3d& way_point :
       {Eigen::Vector3d(middle, 5, 3), Eigen::Vector3d(middle + 1, 6, 3),
        Eigen::Vector3d(middle + 1, 4, 3), Eigen::Vector3d(middle + 1, 4, 2.5)}) {
    double nearest = 1e9;
    for (const auto& pose : flight) {
      nearest = std::min(nearest, (pose.inverse().translation() - way_point).norm());
    }
    EXPECT_LT(nearest, 0.15);
  }
}

TEST(PaperFlight, IsThatOfItsSeed) {
  const auto model = parallel_rack(2);
  const auto one = paper_flight(model, {}, kSeed);
  const auto same = paper_flight(model, {}, kSeed);
  const auto other = paper_flight(model, {}, kSeed + 1);
  EXPECT_EQ(one.back().matrix(), same.back().matrix());
  EXPECT_NE(one.back().matrix(), other.back().matrix());
}

TEST(PaperRack, HasTheSizesOfThePaper) {
  const auto model = paper_rack();
  ASSERT_EQ(model.pipes.size(), 5U);
  EXPECT_EQ(model.pipes[0].radii.front().radius, 0.15);
  EXPECT_EQ(model.pipes[0].radii.back().radius, 0.20);
  EXPECT_EQ(model.pipes[4].direction, Eigen::Vector3d::UnitX());
  EXPECT_EQ(paper_rack(3).pipes.size(), 3U);
}

TEST(PoseRun, IdealCameraGivesTheTruth) {
  const auto model = paper_rack();
  const auto flight = paper_flight(model, {}, kSeed);
  const auto errors = run_poses(model, flight, {.points = 125}, kSeed);
  EXPECT_EQ(errors.frames, flight.size());
  EXPECT_EQ(errors.not_ok, 0U);
  EXPECT_LE(errors.position_rms(), 0.001);
  EXPECT_LE(errors.orientation_rms_degrees(), 0.02);
}

TEST(TableOne, ACellIsNearItsBound) {
  const auto cells = table_one_cells();
  ASSERT_EQ(cells.size(), 20U);
  const auto cell = std::ranges::find_if(
      cells, [](const TableCell& c) { return c.pipes == 4 && c.points == 20; });
  const std::uint64_t seeds[] = {1, 2};
  const CellScore score = score_cell(*cell, {.every = 4}, seeds);
  EXPECT_LE(score.ratio_to_bound(), 1.2);
  EXPECT_TRUE(score.half_of(*cell));
  EXPECT_TRUE(score.bound_half_of(*cell));
  EXPECT_FALSE(score.above(*cell));
  EXPECT_EQ(score.position.size(), 2U);
  // Of six degrees of freedom; frames of one flight are independent.
  EXPECT_NEAR(score.all.consistency / static_cast<double>(score.all.frames), 6, 1);
}

TEST(Offsets, ConvergeAsFigureEightAndFollowPipesThatMove) {
  const auto ideal = run_offsets({.frames = 30}, kSeed);
  EXPECT_LE(frames_until(ideal, &OffsetFrame::largest_error, 0.001), 5U);
  const auto noisy = run_offsets({.noise = true, .frames = 60}, kSeed);
  EXPECT_LE(noisy[24].largest_error, 0.005);
  const auto moving = run_offsets({.scenario = OffsetScenario::kMovingPipes, .noise = true}, kSeed);
  EXPECT_GT(moving[kPushedAtFrame].step_error, 0.01);
  EXPECT_LE(frames_until(moving, &OffsetFrame::step_error, 0.01, kPushedAtFrame), 25U);
}

TEST(Offsets, FramesUntilCountsTheFirstImage) {
  const std::vector<OffsetFrame> run{{1, 0, 0}, {0.1, 0, 0}, {0.3, 0, 0}, {0.1, 0, 0}, {0.1, 0, 0}};
  EXPECT_EQ(frames_until(run, &OffsetFrame::largest_error, 2), 1U);
  EXPECT_EQ(frames_until(run, &OffsetFrame::largest_error, 0.2), 4U);
  EXPECT_EQ(frames_until(run, &OffsetFrame::largest_error, 0.2, 3), 1U);
  EXPECT_EQ(frames_until(run, &OffsetFrame::largest_error, 0.01), 5U);
}

TEST(FirstPose, WrongByFiveCentimetresAndDegreesConverges) {
  const auto score = try_first_poses({.outlier_share = 0.3}, 60, kSeed);
  EXPECT_EQ(score.trials, 60U);
  EXPECT_EQ(score.silent_wrong, 0U);
  EXPECT_EQ(score.converged + score.refused, 60U);
}

}  // namespace
}  // namespace pipescout::rack_study
