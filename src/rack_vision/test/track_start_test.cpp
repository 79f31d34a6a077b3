// SPDX-License-Identifier: Apache-2.0
// What a start must not be misled by where pipes may lie elsewhere than the rack file has them.
#include <gtest/gtest.h>

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

RackTrackerResult started(const RackModel& drawn, const RackModel& model, double place,
                          double turn) {
  const geometry::Camera camera = drawn_camera();
  RackTrackerParameters parameters;
  parameters.offset_sigma = 0.02;
  RackTracker tracker(model, camera, parameters);
  geometry::Vector6d deviations;
  deviations << place, place, place, turn, turn, turn;
  EXPECT_TRUE(
      tracker.set_pose(camera_pose(), geometry::Matrix6d(deviations.cwiseAbs2().asDiagonal())));
  const DrawnImage image = draw(drawn, camera, camera_pose());
  return tracker.track(image.view(), 0);
}

TEST(TrackStart, IsTakenOverPipesThatLieElsewhere) {
  RackModel drawn = rack_on_a_beam();
  drawn.pipes[1].start.x() += 0.012;
  drawn.pipes[2].start.x() -= 0.008;
  drawn.pipes[3].start.x() += 0.015;
  const RackTrackerResult result = started(drawn, rack_on_a_beam(), 0.03, 0.03);
  ASSERT_EQ(result.status, TrackStatus::kTracking) << result.reason;
  const Eigen::Vector3d error = result.T_rack_camera.translation() - camera_pose().translation();
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(error(i)), 3 * std::sqrt(result.covariance(i, i))) << i;
  }
}

TEST(TrackStart, IsRefusedWhereThePipeThatDefinesTheFrameIsNot) {
  RackModel drawn = rack_on_a_beam();
  drawn.pipes[0].start.x() -= 0.08;
  const RackTrackerResult result = started(drawn, rack_on_a_beam(), 0.01, 0.005);
  EXPECT_EQ(result.status, TrackStatus::kLost);
  EXPECT_FALSE(result.reason.empty());
}

}  // namespace
}  // namespace pipescout::rack_vision
