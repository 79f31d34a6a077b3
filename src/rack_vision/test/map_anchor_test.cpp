// SPDX-License-Identifier: Apache-2.0
// Supports tell where along the pipes the map is, however the camera has moved since the last
// image.
#include <gtest/gtest.h>

#include "drawn_rack.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kInterval = 0.04;  // s

TEST(MapAnchor, ASuddenTurnIsNotTakenForAnErrorOfTheMap) {
  const RackModel model = test::rack_on_a_beam();
  const geometry::Camera camera = test::drawn_camera();
  const geometry::SE3 still = test::drawn_pose(0.85, 4.0, 2.6, 0.0);
  const geometry::SE3 said(still.rotation(), still.translation() + Eigen::Vector3d(0, 0.006, 0));
  for (const double turn :
       {-0.010, -0.006, 0.006, 0.010}) {  // rad about x: 16 to 26 mm on the rack
    RackTracker tracker(model, camera);
    geometry::Vector6d deviations;
    deviations << 0.01, 0.01, 0.01, 0.005, 0.005, 0.005;
    ASSERT_TRUE(tracker.set_pose(said, geometry::Matrix6d(deviations.cwiseAbs2().asDiagonal())));
    for (const unsigned i : {0U, 1U}) {
      const test::DrawnImage image = test::noisy(test::draw(model, camera, still), 1, 1U + i);
      const RackTrackerResult before = tracker.track(image.view(), i * kInterval);
      ASSERT_EQ(before.status, TrackStatus::kTracking) << before.reason;
    }
    const geometry::SE3 turned(geometry::SO3::about_x(turn) * still.rotation(),
                               still.translation());
    const test::DrawnImage image = test::draw(model, camera, turned);
    const RackTrackerResult result = tracker.track(image.view(), 2 * kInterval);
    ASSERT_EQ(result.status, TrackStatus::kTracking) << turn << ": " << result.reason;
    EXPECT_LT((result.T_rack_camera.translation() - turned.translation()).norm(), 0.01) << turn;
    EXPECT_LT((result.T_rack_camera.rotation() * turned.rotation().inverse()).log().norm(), 0.004)
        << turn;
  }
}

}  // namespace
}  // namespace pipescout::rack_vision
