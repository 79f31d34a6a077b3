// SPDX-License-Identifier: Apache-2.0
#include "pipe_plane.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rotation_history.hpp"

namespace pipescout::manipulation::internal {
namespace {

using Eigen::Vector3d;
using geometry::SO3;

geometry::Camera camera() {
  return geometry::Camera(
      {.width = 320, .height = 240, .focal_length = 722, .centre_u = 159.5, .centre_v = 119.5});
}

PipeSection section(double u, double v, double length, double angle) {
  return {.state = TrackState::kLocked,
          .width = 320,
          .height = 240,
          .u = u,
          .v = v,
          .length = length,
          .angle = angle};
}

TEST(SectionView, OfALevelPipeInTheMiddle) {
  const auto view = view_of(section(159.5, 119.5, 320, 0), camera());
  ASSERT_TRUE(view);
  EXPECT_LT((view->normal - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_EQ(view->turn, 0);
  EXPECT_NEAR(view->offset, 0, 1e-12);
}

TEST(SectionView, NormalIsAcrossThePipeWhicheverWayItsAngleIsGiven) {
  const auto view = view_of(section(170, 150, 320, 0.2), camera());
  const auto turned = view_of(section(170, 150, 320, 0.2 - std::numbers::pi), camera());
  ASSERT_TRUE(view && turned);
  EXPECT_LT((view->normal - turned->normal).norm(), 1e-12);
  // All of the section's line is in the plane.
  for (const double along : {-100.0, 0.0, 60.0}) {
    const auto ray = camera().ray({170 + along * std::cos(0.2), 150 + along * std::sin(0.2)});
    EXPECT_NEAR(view->normal.dot(*ray), 0, 1e-12);
  }
}

TEST(SectionView, TurnsAfterAnEndInTheImageOnly) {
  EXPECT_EQ(view_of(section(200, 119.5, 400, 0), camera())->turn, 0);
  const auto view = view_of(section(240, 119.5, 160, 0), camera());
  EXPECT_NEAR(view->turn, std::atan(80.5 / 722), 1e-12);
}

TEST(SectionView, RefusesWhatHasNoDirection) {
  EXPECT_FALSE(view_of(section(160, 120, 0.1, 0), camera()));
}

TEST(PipePlane, TurnsAboutThePipeAsTheCameraMoves) {
  // A pipe along x, 10 m ahead of a camera with its axes those of the frame.
  PipePlane plane;
  plane.observe(Vector3d::UnitY(), 10, 1);
  for (int i = 0; i < 100; ++i) {
    plane.move({0.5, 0.002, 0}, Vector3d::UnitZ());
  }
  // 0.2 m down, the camera sees the pipe as much higher.
  const Vector3d to_pipe(0, -0.2, 10);
  EXPECT_NEAR(plane.normal().dot(to_pipe.normalized()), 0, 1e-4);
  EXPECT_NEAR(plane.normal().x(), 0, 1e-12);
}

TEST(PipePlane, IsTheMeanOfImages) {
  PipePlane plane;
  plane.observe(Vector3d::UnitY(), 10, 0.2);
  EXPECT_EQ(plane.normal(), Vector3d::UnitY());
  const Vector3d other(0, std::cos(0.1), std::sin(0.1));
  plane.observe(-other, 12, 0.5);  // a plane has no side
  EXPECT_NEAR(plane.normal().z(), std::sin(0.05), 1e-9);
  EXPECT_NEAR(plane.range(), 11, 1e-12);
}

TEST(LookingAlong, HasTheNormalAsItsDownAndLooksForward) {
  const Vector3d normal = Vector3d(0.1, 0.9, 0.2).normalized();
  const SO3 R = looking_along(normal, Vector3d::UnitZ());
  EXPECT_LT((R * Vector3d::UnitY() - normal).norm(), 1e-12);
  EXPECT_GT((R * Vector3d::UnitZ()).z(), 0.9);
}

TEST(RotationHistory, IsBetweenSamplesAndGoesOnAfterTheLast) {
  RotationHistory history;
  EXPECT_FALSE(history.at(0));
  for (int i = 0; i <= 100; ++i) {
    history.add(0.01 * i, SO3::about_z(0.02 * i), {0, 0, 2}, 0.005);
  }
  for (const double time : {0.0, 0.333, 0.5, 1.0, 1.05}) {
    const auto rotation = history.at(time);
    ASSERT_TRUE(rotation);
    EXPECT_LT((rotation->inverse() * SO3::about_z(2 * time)).log().norm(), 1e-9) << time;
  }
  EXPECT_FALSE(history.at(-0.1));
}

TEST(RotationHistory, CoversASecondOfQuickSamples) {
  RotationHistory history;
  for (int i = 0; i <= 4000; ++i) {
    history.add(0.001 * i, SO3::about_x(0.0001 * i), {0.1, 0, 0}, 0.01);
  }
  ASSERT_TRUE(history.at(3.0));
  EXPECT_NEAR(history.at(3.0)->log().x(), 0.3, 1e-9);
  EXPECT_NEAR(history.at(4.0)->log().x(), 0.4, 1e-9);
}

}  // namespace
}  // namespace pipescout::manipulation::internal
