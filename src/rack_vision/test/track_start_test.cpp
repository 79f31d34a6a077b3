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

/// The first image of a camera that is at `camera_pose()` and said to be `error` beside it.
struct Start {
  Start(const RackModel& drawn, const RackModel& model, const Known& known,
        const Eigen::Vector3d& error = Eigen::Vector3d::Zero())
      : tracker(model, drawn_camera(), parameters(known)) {
    geometry::Vector6d deviations;
    deviations << Eigen::Vector3d::Constant(known.place), Eigen::Vector3d::Constant(known.turn);
    EXPECT_TRUE(tracker.set_pose({camera_pose().rotation(), camera_pose().translation() + error},
                                 geometry::Matrix6d(deviations.cwiseAbs2().asDiagonal())));
    const DrawnImage image = draw(drawn, drawn_camera(), camera_pose());
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

}  // namespace
}  // namespace pipescout::rack_vision
