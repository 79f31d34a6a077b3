// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking_study/tracking_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace pipescout::tracking_study {
namespace {

using tracking::PipeShape;
using State = PipeShape::State;

/// A level pipe that stands still, seen exactly.
Recording still_recording(std::size_t pictures) {
  Recording recording;
  recording.camera = geometry::Camera(
      {.width = 320, .height = 240, .focal_length = 721, .centre_u = 159.5, .centre_v = 119.5});
  recording.depth = 10;
  for (std::size_t i = 0; i < pictures; ++i) {
    recording.regions.push_back({.start = {60, 100}, .end = {260, 100}, .half_width = 6});
    recording.pictures.push_back({.time = 0.1 * static_cast<double>(i),
                                  .first_region = i,
                                  .regions = 1,
                                  .truth = State(160, 100, 200, 0)});
  }
  return recording;
}

TEST(Moments, OfKnownValues) {
  Moments moments;
  EXPECT_TRUE(std::isnan(moments.mean()));
  for (const double value : {1.0, 2.0, 3.0}) {
    moments.add(value);
  }
  Moments others;
  others.add(6);
  moments += others;
  EXPECT_EQ(moments.count(), 4U);
  EXPECT_DOUBLE_EQ(moments.mean(), 3);
  EXPECT_DOUBLE_EQ(moments.deviation(), std::sqrt(14.0 / 4));
}

TEST(DeviationInterval, IsAsWideAsSequencesDiffer) {
  std::vector<Moments> sequences(50);
  EXPECT_TRUE(std::isnan(deviation_interval(sequences, 1).low));
  for (std::size_t i = 0; i < sequences.size(); ++i) {
    for (const double value : {1.0, 3.0}) {
      sequences[i].add(value);
    }
  }
  EXPECT_DOUBLE_EQ(deviation_interval(sequences, 1).low, 1);
  EXPECT_DOUBLE_EQ(deviation_interval(sequences, 1).high, 1);
  // One value of one sequence: it is in two of three resamples, (1 - 1/50)^50 = 0.36.
  sequences[7].add(102);
  const DeviationInterval interval = deviation_interval(sequences, 1);
  EXPECT_DOUBLE_EQ(interval.low, 1);
  EXPECT_GT(interval.high, 10);
  EXPECT_EQ(interval.high, deviation_interval(sequences, 1).high);
}

TEST(EstimateErrors, AreThoseOfThePaper) {
  EstimateErrors errors;
  constexpr double kDegree = std::numbers::pi / 180;
  errors.add({103, 104, 50, 89 * kDegree}, {100, 100, 55, -90 * kDegree});
  EXPECT_DOUBLE_EQ(errors.position.mean(), 5);
  EXPECT_NEAR(errors.angle.mean(), 1, 1e-9);
  EXPECT_DOUBLE_EQ(errors.length.mean(), 5);
  EXPECT_FALSE(kTableOne[0].covers(errors));
  EstimateErrors none;
  none.add({100, 100, 55, 0}, {100, 100, 55, 0});
  EXPECT_TRUE(kTableOne[5].covers(none));
}

TEST(PaperFilter, FollowsWhatStandsStill) {
  const TrackingScore score = score_paper_filter(still_recording(100), {}, 1);
  EXPECT_EQ(score.pictures, 100U);
  EXPECT_EQ(score.lost_tracks, 0U);
  EXPECT_EQ(score.errors[kOurs].position.count(), 0U);
  EXPECT_LT(score.errors[kRobustMean].position.mean(), 2.0);
  EXPECT_LT(score.errors[kBestParticle].angle.mean(), 1.0);
  EXPECT_TRUE(kTableOne[0].covers_deviations(score.errors[kRobustMean]));
}

TEST(TrackingScore, OfWhatStandsStill) {
  const TrackingScore score = score_tracking(still_recording(100), {}, 1);
  EXPECT_EQ(score.lost_tracks, 0U);
  EXPECT_EQ(score.pictures, 98U) << "locked on with the third";
  EXPECT_LT(score.errors[kOurs].position.mean(), 0.01);
  EXPECT_LT(score.errors[kWeightedMean].position.mean(), 2);
  EXPECT_GT(score.errors[kBestParticle].position.mean(), 0);
}

TEST(TrackingScore, ATrackThatIsNotOnTheTubeForASecondIsLost) {
  Recording recording = still_recording(100);
  for (std::size_t i = 40; i < 60; ++i) {
    recording.pictures[i].truth = State(160, 150, 200, 0);
  }
  EXPECT_EQ(score_tracking(recording, {}, 1).lost_tracks, 1U);
  for (std::size_t i = 40; i < 60; ++i) {
    recording.pictures[i].truth.reset();
  }
  EXPECT_EQ(score_tracking(recording, {}, 1).lost_tracks, 0U) << "not in view";
}

TEST(TrackingScore, GapsAreScoredByThemselvesToo) {
  Recording recording = still_recording(100);
  for (std::size_t i = 40; i < 45; ++i) {
    recording.pictures[i].gap = true;
    recording.pictures[i].regions = 0;
  }
  const TrackingScore score = score_tracking(recording, {}, 1);
  EXPECT_EQ(score.in_gaps.position.count(), 5U);
  EXPECT_EQ(score.lost_tracks, 0U);
  TrackingScore both = score;
  both += score;
  EXPECT_EQ(both.pictures, 2 * score.pictures);
}

}  // namespace
}  // namespace pipescout::tracking_study
