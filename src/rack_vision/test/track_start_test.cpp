// SPDX-License-Identifier: Apache-2.0
// What a start must not be misled by where pipes may lie elsewhere than the rack file has them.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "drawn_rack.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"

namespace pipescout::rack_vision {
namespace {

using test::draw;
using test::drawn_camera;
using test::drawn_pose;
using test::drawn_rack;
using test::DrawnImage;
using test::rack_on_a_beam;

constexpr double kHeight = 2.6;  // m

geometry::SE3 camera_pose() {
  return drawn_pose(0.85, 4.0, kHeight, 0.0);
}

/// What is known before the image, one sigma.
struct Known {
  double place = 0.01;   ///< m
  double turn = 0.005;   ///< rad
  double offset = 0.02;  ///< m
};

/// The first image of a camera that is at `at` and said to be `error` beside it.
struct Start {
  Start(const RackModel& drawn, const RackModel& model, const Known& known,
        const Eigen::Vector3d& error = Eigen::Vector3d::Zero(),
        const geometry::SE3& at = camera_pose())
      : tracker(model, drawn_camera(), parameters(known)) {
    geometry::Vector6d deviations;
    deviations << Eigen::Vector3d::Constant(known.place), Eigen::Vector3d::Constant(known.turn);
    EXPECT_TRUE(tracker.set_pose({at.rotation(), at.translation() + error},
                                 geometry::Matrix6d(deviations.cwiseAbs2().asDiagonal())));
    const DrawnImage image = draw(drawn, drawn_camera(), at);
    result = tracker.track(image.view(), 0);
  }

  static RackTrackerParameters parameters(const Known& known) {
    RackTrackerParameters result;
    result.offset_sigma = known.offset;
    return result;
  }

  RackTracker tracker;
  RackTrackerResult result;
};

RackModel moved(RackModel model, const std::array<double, 4>& offsets) {
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    model.pipes[i].start.x() += offsets[i];
  }
  return model;
}

void expect_pose_and_offsets(const RackTrackerResult& result,
                             const std::array<double, 4>& offsets) {
  ASSERT_EQ(result.status, TrackStatus::kTracking) << result.reason;
  const Eigen::Vector3d error = result.T_rack_camera.translation() - camera_pose().translation();
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(error(i)), 0.02) << i;
    EXPECT_LT(std::abs(error(i)), 3 * std::sqrt(result.covariance(i, i))) << i;
  }
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    EXPECT_NEAR(result.offsets[i], offsets[i], 0.015) << i;
    EXPECT_LE(std::abs(result.offsets[i] - offsets[i]), 3 * std::sqrt(result.offset_variances[i]))
        << i;
  }
}

TEST(TrackStart, IsTakenOverPipesThatLieElsewhere) {
  RackModel drawn = rack_on_a_beam();
  drawn.pipes[1].start.x() += 0.012;
  drawn.pipes[2].start.x() -= 0.008;
  drawn.pipes[3].start.x() += 0.015;
  const Start start(drawn, rack_on_a_beam(), {.place = 0.03, .turn = 0.03});
  const RackTrackerResult& result = start.result;
  ASSERT_EQ(result.status, TrackStatus::kTracking) << result.reason;
  const Eigen::Vector3d error = result.T_rack_camera.translation() - camera_pose().translation();
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(error(i)), 3 * std::sqrt(result.covariance(i, i))) << i;
  }
}

TEST(TrackStart, IsRefusedWhereThePipeThatDefinesTheFrameIsNot) {
  RackModel drawn = rack_on_a_beam();
  drawn.pipes[0].start.x() -= 0.08;
  const Start start(drawn, rack_on_a_beam(), {});
  const RackTrackerResult& result = start.result;
  EXPECT_EQ(result.status, TrackStatus::kLost);
  EXPECT_FALSE(result.reason.empty());
}

TEST(TrackStart, FindsPipesFartherFromTheFileThanWasSaid) {
  constexpr std::array kOffsets{0.0, -0.055, 0.05, 0.02};  // m
  const Start start(moved(rack_on_a_beam(), kOffsets), rack_on_a_beam(), {.offset = 0.01},
                    {0.008, -0.006, 0.01});
  expect_pose_and_offsets(start.result, kOffsets);
}

TEST(TrackStart, FindsPipesThatMayLieAnywhere) {
  constexpr std::array kOffsets{0.0, 0.05, 0.15, 0.20};  // m
  const Start start(moved(rack_on_a_beam(), kOffsets), rack_on_a_beam(), {.offset = 0.2},
                    {0.008, -0.006, 0.01});
  expect_pose_and_offsets(start.result, kOffsets);
}

/// A pipe that lies elsewhere, and another one beside it that looks like it.
constexpr std::array kBeside{0.0, 0.0, 0.0, -0.06};  // m

RackModel with_another_pipe() {
  RackModel drawn = moved(drawn_rack(), kBeside);
  drawn.pipes.push_back(drawn_rack().pipes[3]);
  drawn.pipes.back().name = "another";
  drawn.pipes.back().start.x() += 0.15;
  return drawn;
}

TEST(TrackStart, DoesWithoutAPipeThatMayBeEitherOfTwo) {
  constexpr double kOffset = 0.15;  // m
  const Start start(with_another_pipe(), drawn_rack(), {.offset = kOffset});
  ASSERT_EQ(start.result.status, TrackStatus::kTracking) << start.result.reason;
  const Eigen::Vector3d error =
      start.result.T_rack_camera.translation() - camera_pose().translation();
  EXPECT_LT(error.norm(), 0.02);
  EXPECT_EQ(start.result.offset_observed[3], 0);
  EXPECT_NEAR(std::sqrt(start.result.offset_variances[3]), kOffset, 1e-6);
}

TEST(TrackStart, PlacesAPipeOnceOnlyOnePlaceIsLeft) {
  Start start(with_another_pipe(), drawn_rack(), {.offset = 0.15});
  ASSERT_EQ(start.result.offset_observed[3], 0);
  RackTrackerResult result;
  for (int i = 1; i <= 12; ++i) {
    const geometry::SE3 T_rack_camera = drawn_pose(0.85 + 0.001 * i, 4.0 + 0.004 * i, kHeight, 0.0);
    const DrawnImage image = draw(moved(drawn_rack(), kBeside), drawn_camera(), T_rack_camera);
    result = start.tracker.track(image.view(), 0.04 * i);
    ASSERT_EQ(result.status, TrackStatus::kTracking) << i << ": " << result.reason;
    const Eigen::Vector3d error = result.T_rack_camera.translation() - T_rack_camera.translation();
    EXPECT_LT(error.norm(), 0.02) << i;
  }
  EXPECT_NE(result.offset_observed[3], 0);
  EXPECT_NEAR(result.offsets[3], kBeside[3], 0.01);
  EXPECT_LT(std::sqrt(result.offset_variances[3]), 0.01);
}

/// Stated of the height, m, one sigma, after the camera has seen other views.
double deviation_after_flight(Start& start, const RackModel& drawn) {
  constexpr int kImages = 30;
  constexpr double kWay = 0.06;  // m, an image
  RackTrackerResult result = start.result;
  for (int i = 1; i <= kImages; ++i) {
    const geometry::SE3 T_rack_camera = drawn_pose(0.85, 4.0 + kWay * i, kHeight, 0.0);
    result = start.tracker.track(draw(drawn, drawn_camera(), T_rack_camera).view(), 0.04 * i);
    EXPECT_EQ(result.status, TrackStatus::kTracking) << i << ": " << result.reason;
  }
  return std::sqrt(result.covariance(2, 2));
}

TEST(TrackStart, ManyImagesDoNotMakeCertainWhatRestsOnPipesThatWereSearched) {
  const RackModel drawn = moved(rack_on_a_beam(), {0.0, -0.055, 0.05, 0.02});
  Start where_they_are(drawn, drawn, {.offset = 0.01});
  Start searched(drawn, rack_on_a_beam(), {.offset = 0.01});
  EXPECT_GT(deviation_after_flight(searched, drawn),
            1.5 * deviation_after_flight(where_they_are, drawn));
}

TEST(TrackStart, KnowsNoPlaceAcrossBeforeThePipeThatDefinesItIsSeen) {
  constexpr double kAside = 2.0;             // m: from there the first pipe is out of view
  constexpr double kWay = 0.02;              // m, an image
  constexpr double kTakenForOthers = 0.035;  // m
  const RackModel drawn = moved(drawn_rack(), {0.0, -0.055, 0.05, 0.02});
  Start start(drawn, drawn_rack(), {.offset = 0.01}, Eigen::Vector3d::Zero(),
              drawn_pose(kAside, 4.0, kHeight, 0.0));
  ASSERT_EQ(start.result.status, TrackStatus::kTracking) << start.result.reason;
  EXPECT_GT(std::sqrt(start.result.covariance(0, 0)), kTakenForOthers);
  RackTrackerResult result;
  for (int i = 1; kAside - kWay * i > 0.9; ++i) {
    const geometry::SE3 T_rack_camera = drawn_pose(kAside - kWay * i, 4.0, kHeight, 0.0);
    result = start.tracker.track(draw(drawn, drawn_camera(), T_rack_camera).view(), 0.04 * i);
    ASSERT_EQ(result.status, TrackStatus::kTracking) << i << ": " << result.reason;
    const double error = result.T_rack_camera.translation().x() - T_rack_camera.translation().x();
    EXPECT_LT(std::abs(error), 3 * std::sqrt(result.covariance(0, 0))) << i;
  }
  EXPECT_LT(std::sqrt(result.covariance(0, 0)), kTakenForOthers);
}

}  // namespace
}  // namespace pipescout::rack_vision
