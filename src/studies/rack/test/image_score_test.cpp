// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/image_score.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <vector>

#include "pipescout/rack_study/image_trials.hpp"

namespace pipescout::rack_study {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::Optional;

FrameScore posed(double time, double along_error) {
  FrameScore frame;
  frame.time = time;
  frame.status = rack_vision::TrackStatus::kTracking;
  frame.has_pose = true;
  frame.error(1) = along_error;
  return frame;
}

FrameScore without_pose(double time) {
  FrameScore frame;
  frame.time = time;
  frame.status = rack_vision::TrackStatus::kLost;
  return frame;
}

FrameScore outage(FrameScore frame) {
  frame.outage = true;
  return frame;
}

TEST(IsWrong, BeyondThreeCentimetresOrOneDegree) {
  EXPECT_FALSE(is_wrong(posed(0, 0.0299)));
  EXPECT_TRUE(is_wrong(posed(0, 0.0301)));
  FrameScore turned = posed(0, 0);
  turned.error(5) = 0.017;
  EXPECT_FALSE(is_wrong(turned));
  turned.error(5) = 0.018;
  EXPECT_TRUE(is_wrong(turned));
}

TEST(IsWrong, NoPoseIsNotWrongAndNaNIs) {
  EXPECT_FALSE(is_wrong(without_pose(0)));
  EXPECT_TRUE(is_wrong(posed(0, std::numeric_limits<double>::quiet_NaN())));
}

TEST(ScoreFlight, CountsPosesAndCoverageOutsideOutages) {
  std::vector<FrameScore> frames{posed(0, 0.001), posed(0.04, 0.05), without_pose(0.08),
                                 outage(posed(0.12, 0.2))};
  frames[0].position_nees = 7.8;
  frames[0].pose_nees = 12.6;
  frames[0].error(3) = 0.002;
  frames[1].position_nees = 7.9;
  frames[1].pose_nees = 12.5;
  const auto score = score_flight(frames);
  EXPECT_EQ(score.images, 3U);
  EXPECT_EQ(score.with_pose, 2U);
  EXPECT_EQ(score.wrong, 1U);
  EXPECT_EQ(score.position_covered, 1U);
  EXPECT_EQ(score.pose_covered, 1U);
  EXPECT_THAT(score.position_errors, ElementsAre(0.001, 0.05));
  EXPECT_THAT(score.rotation_errors, ElementsAre(0.002, 0.0));
  EXPECT_NEAR(score.with_pose_percent(), 200.0 / 3.0, 1e-12);
}

TEST(ScoreFlight, SumsAreThoseOfTheFramesTogether) {
  const std::vector<FrameScore> frames{posed(0, 0.001), without_pose(0.04)};
  auto sum = score_flight(frames);
  sum += score_flight(frames);
  EXPECT_EQ(sum.images, 4U);
  EXPECT_EQ(sum.with_pose, 2U);
  EXPECT_EQ(sum.position_errors.size(), 2U);
  EXPECT_EQ(ImageFlightScore{}.with_pose_percent(), 100.0);
}

/// Along the pipes at 0.1 m an image, the error growing by `drift` m per image.
std::vector<FrameScore> drifting(std::size_t count, double drift) {
  std::vector<FrameScore> frames;
  for (std::size_t i = 0; i < count; ++i) {
    const auto image = static_cast<double>(i);
    frames.push_back(posed(0.04 * image, 0.5 + drift * image));
    frames.back().along = 2 + 0.1 * image;
  }
  return frames;
}

TEST(AlongDrift, IsTheChangeOfTheErrorOverTheWay) {
  EXPECT_NEAR(along_drift_percent(drifting(100, 0.0002)), 0.2, 1e-9);
  EXPECT_NEAR(along_drift_percent(drifting(100, -0.0002)), 0.2, 1e-9);
  EXPECT_NEAR(along_drift_percent(drifting(100, 0)), 0, 1e-9);
}

TEST(AlongDrift, OfATrackThatEndsIsInfinite) {
  auto frames = drifting(100, 0);
  frames.back().has_pose = false;
  EXPECT_TRUE(std::isinf(along_drift_percent(frames)));
  EXPECT_TRUE(std::isinf(along_drift_percent(drifting(19, 0))));
  EXPECT_TRUE(std::isinf(along_drift_percent({})));
}

TEST(ScoreRecovery, FromTheFirstImageAfterTheOutage) {
  const std::vector<FrameScore> frames{
      posed(0, 0),     outage(posed(1, 0.01)), outage(without_pose(1.5)),
      without_pose(2), without_pose(2.3),      posed(2.6, 0.001)};
  const auto recovery = score_recovery(frames);
  EXPECT_TRUE(recovery.declared);
  EXPECT_FALSE(recovery.wrong);
  EXPECT_THAT(recovery.time, Optional(DoubleNear(0.6, 1e-12)));
}

TEST(ScoreRecovery, AWrongPoseIsNoRecovery) {
  const std::vector<FrameScore> frames{outage(without_pose(1)), posed(2, 0.1), posed(2.5, 0.01)};
  const auto recovery = score_recovery(frames);
  EXPECT_TRUE(recovery.wrong);
  EXPECT_THAT(recovery.time, Optional(DoubleNear(0.5, 1e-12)));
  EXPECT_FALSE(score_recovery(std::span(frames).first(2)).time);
}

TEST(ScoreRecovery, WithoutAnOutageThereIsNothingToSay) {
  const std::vector<FrameScore> frames{posed(0, 0.1), without_pose(1), posed(2, 0)};
  const auto recovery = score_recovery(frames);
  EXPECT_FALSE(recovery.declared);
  EXPECT_FALSE(recovery.wrong);
  EXPECT_FALSE(recovery.time);
}

TEST(ScoreStretch, TakesImagesBetweenTwoPlaces) {
  std::vector<FrameScore> frames;
  for (int i = 0; i < 6; ++i) {
    frames.push_back(posed(i, -0.01 * i));
    frames.back().along = i;
    frames.back().along_deviation = 0.1 * i;
    frames.back().position_nees = i == 3 ? 8 : 1;
  }
  frames[4].has_pose = false;
  const auto score = score_stretch(frames, 1.5, 4.5);
  EXPECT_EQ(score.images, 3U);
  EXPECT_EQ(score.with_pose, 2U);
  EXPECT_EQ(score.covered, 1U);
  EXPECT_NEAR(score.largest_error, 0.03, 1e-12);
  EXPECT_NEAR(score.first_deviation, 0.2, 1e-12);
  EXPECT_NEAR(score.last_deviation, 0.3, 1e-12);
}

FrameScore wrong_with_nees(double nees) {
  FrameScore frame = posed(0, 0.04);
  frame.pose_nees = nees;
  return frame;
}

TEST(ScoreWrongStarts, RightWrongOrLost) {
  const std::vector<WrongStartTrial> trials{{.last = posed(0, 0.01)},
                                            {.last = posed(0, 0.02)},
                                            {.last = wrong_with_nees(17)},
                                            {.last = wrong_with_nees(16)},
                                            {.last = without_pose(0)}};
  auto score = score_wrong_starts(trials);
  score += score_wrong_starts(std::span(trials).first(1));
  EXPECT_EQ(score.trials, 6U);
  EXPECT_EQ(score.converged, 3U);
  EXPECT_EQ(score.silent_wrong, 1U);
  EXPECT_EQ(score.admitted_wrong, 1U);
  EXPECT_EQ(score.lost, 1U);
}

rack_vision::RackTrackerResult tracked_at(const geometry::SE3& T_rack_camera) {
  rack_vision::RackTrackerResult result;
  result.status = rack_vision::TrackStatus::kTracking;
  result.T_rack_camera = T_rack_camera;
  result.covariance = 1e-4 * geometry::Matrix6d::Identity();
  return result;
}

TEST(ScoreFrame, ErrorsAreInRackAxes) {
  const geometry::SE3 truth(geometry::SO3::about_x(3), {1, 5, 3});
  const geometry::SE3 estimate(geometry::SO3::about_z(0.02) * truth.rotation(), {1.01, 4.98, 3.03});
  auto result = tracked_at(estimate);
  result.covariance(1, 1) = 4e-4;
  const auto score = score_frame(result, truth.inverse());
  geometry::Vector6d expected;
  expected << 0.01, -0.02, 0.03, 0, 0, 0.02;
  EXPECT_LT((score.error - expected).norm(), 1e-12);
  EXPECT_NEAR(score.along_deviation, 0.02, 1e-15);
  EXPECT_NEAR(score.position_nees, 1 + 1 + 9, 1e-9);
  EXPECT_NEAR(score.pose_nees, 1 + 1 + 9 + 4, 1e-9);
  EXPECT_NEAR(score.along, 5, 1e-12);
}

TEST(ScoreFrame, LostHasNoPose) {
  auto result = tracked_at({});
  for (const auto status : {rack_vision::TrackStatus::kLost, rack_vision::TrackStatus::kBadImage,
                            rack_vision::TrackStatus::kNotStarted}) {
    result.status = status;
    const auto score = score_frame(result, geometry::SE3({}, {0, 1, 0}));
    EXPECT_FALSE(score.has_pose);
    EXPECT_EQ(score.error.norm(), 0);
  }
}

TEST(ScoreFrame, ACovarianceThatIsNoneCoversNothing) {
  auto result = tracked_at({});
  result.covariance(2, 2) = -1;
  const auto score = score_frame(result, {});
  EXPECT_TRUE(std::isinf(score.position_nees));
  EXPECT_TRUE(std::isinf(score.pose_nees));
}

}  // namespace
}  // namespace pipescout::rack_study
