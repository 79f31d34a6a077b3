// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/image_scene.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace pipescout::rack_study {
namespace {

using ::testing::AllOf;
using ::testing::Ge;
using ::testing::Le;

TEST(Racks, AreValidAndWhatTheySay) {
  const auto on_beams = rack_on_beams();
  EXPECT_EQ(on_beams.pipes.size(), 5U);
  EXPECT_EQ(on_beams.supports.size(), 6U);
  const auto plain = rack_without_beams(14);
  EXPECT_EQ(plain.pipes.size(), 4U);
  EXPECT_TRUE(plain.supports.empty());
  for (const auto& pipe : plain.pipes) {
    EXPECT_EQ(pipe.length(), 14);
  }
}

TEST(InspectionWayPoints, TakeAtLeastTheTimeAndStayOverTheRack) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto way_points = inspection_way_points(60, seed);
    EXPECT_GE(rack_vision::WayPointPath(way_points, {}).duration(), 60);
    for (const auto& way_point : way_points) {
      EXPECT_THAT(way_point.position.y(), AllOf(Ge(2), Le(8)));
      EXPECT_THAT(way_point.position.z(), AllOf(Ge(2.5), Le(3)));
    }
  }
  EXPECT_NE(inspection_way_points(60, 1).back().position,
            inspection_way_points(60, 2).back().position);
}

TEST(FlyCamera, SameSeedSameBits) {
  const CameraFlightSettings settings{.duration = 3};
  const auto way_points = inspection_way_points(3, 1);
  const auto once = fly_camera(way_points, settings, 5);
  const auto twice = fly_camera(way_points, settings, 5);
  const auto other = fly_camera(way_points, settings, 6);
  ASSERT_EQ(once.size(), twice.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].T_camera_rack.matrix(), twice[i].T_camera_rack.matrix());
    EXPECT_EQ(once[i].velocity, twice[i].velocity);
  }
  EXPECT_NE(once.back().T_camera_rack.matrix(), other.back().T_camera_rack.matrix());
}

TEST(FlyCamera, ImagesComeAtTheirRate) {
  const auto motions = fly_camera(way_points_along(2, 4), {.duration = 2, .frame_rate = 6}, 1);
  ASSERT_EQ(motions.size(), 12U);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    EXPECT_NEAR(motions[i].time, static_cast<double>(i) / 6, 0.5e-3 + 1e-9);
  }
}

TEST(FlyCamera, LooksDownAndFollowsThePath) {
  const auto way_points = way_points_along(2, 4);
  const rack_vision::WayPointPath path(way_points, {});
  for (const auto& motion : fly_camera(way_points, {.duration = 8}, 1)) {
    const geometry::SE3 T_rack_camera = motion.T_camera_rack.inverse();
    EXPECT_LT((T_rack_camera.translation() - path.at(motion.time).position).norm(), 0.3);
    EXPECT_LT((T_rack_camera.rotation() * Eigen::Vector3d::UnitZ()).z(), -std::cos(0.3));
  }
}

TEST(FlyCamera, VelocityIsTheDerivativeOfThePose) {
  const CameraFlightSettings settings{.duration = 4, .frame_rate = 1000};
  const auto motions = fly_camera(way_points_along(2, 4), settings, 3);
  for (std::size_t i = 1500; i + 1 < motions.size(); i += 100) {
    const geometry::SE3 before = motions[i - 1].T_camera_rack.inverse();
    const geometry::SE3 after = motions[i + 1].T_camera_rack.inverse();
    // Right perturbation: in the camera frame.
    const geometry::Vector6d difference = (before.inverse() * after).log() / 2e-3;
    EXPECT_LT((motions[i].velocity - difference).norm(), 2e-2) << "image " << i;
  }
}

}  // namespace
}  // namespace pipescout::rack_study
