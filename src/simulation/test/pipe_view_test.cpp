// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/pipe_view.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "pipescout/simulation/thermal_patrol.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const StraightPipe kPipe{.from = {-1000, 10, 3}, .to = {1000, 10, 3}, .radius = 0.06};

geometry::Camera camera() {
  return geometry::Camera(ThermalCameraParameters::qvga().camera);
}

geometry::SE3 side(double height, double roll = 0) {
  return T_body_side_camera({5, 0, height}, 0) *
         geometry::SE3(geometry::SO3::about_z(roll), Vector3d::Zero());
}

TEST(PipeView, OfALevelPipe) {
  const auto view = view_pipe(kPipe, camera(), side(3));
  ASSERT_TRUE(view);
  const auto parameters = camera().parameters();
  EXPECT_NEAR(std::min(view->from.x(), view->to.x()), 0, 1e-9);
  EXPECT_NEAR(std::max(view->from.x(), view->to.x()), parameters.width - 1, 1e-9);
  EXPECT_NEAR(view->from.y(), parameters.centre_v, 1e-9);
  EXPECT_NEAR(view->range, 10, 1e-6);
  EXPECT_TRUE(view->whole_width);
}

TEST(PipeView, AxisGoesThroughThePointsThatAreProjected) {
  const geometry::SE3 T = side(2.5, 0.1);
  const auto view = view_pipe(kPipe, camera(), T);
  ASSERT_TRUE(view);
  for (const double place : {4.0, 5.0, 6.5}) {
    const auto pixel = camera().project(T.inverse() * Vector3d(place, 10, 3));
    const Vector2d along = (view->to - view->from).normalized();
    const Vector2d off = *pixel - view->from;
    EXPECT_NEAR(off.x() * along.y() - off.y() * along.x(), 0, 1e-6);
  }
}

TEST(PipeView, WholeWidthEndsWhereAnEdgeLeavesTheImage) {
  const auto parameters = camera().parameters();
  // The edge's ray touches the pipe: its angle from the axis has the sine radius / distance.
  const double border = std::atan(parameters.centre_v / parameters.focal_length);
  const auto at = [&](double share) {
    // Height at which the lower edge is just on the lower border.
    double low = 3;
    double high = 5;
    for (int i = 0; i < 60; ++i) {
      const double up = (low + high) / 2;
      const double distance = std::hypot(10.0, up - 3);
      const double edge = std::atan((up - 3) / 10) + std::asin(0.06 / distance);
      (edge < border ? low : high) = up;
    }
    return view_pipe(kPipe, camera(), side(low + share));
  };
  ASSERT_TRUE(at(-1e-3) && at(1e-3));
  EXPECT_TRUE(at(-1e-3)->whole_width);
  EXPECT_FALSE(at(1e-3)->whole_width);
}

TEST(PipeView, RolledPipeThatLeavesThroughTheUpperBorderIsNotWhole) {
  const auto view = view_pipe(kPipe, camera(), side(2.2, 0.4));
  ASSERT_TRUE(view);
  EXPECT_FALSE(view->whole_width);
}

TEST(PipeView, EndsOfThePipe) {
  StraightPipe pipe = kPipe;
  pipe.to.x() = 5.5;
  const auto view = view_pipe(pipe, camera(), side(3));
  ASSERT_TRUE(view);
  const auto end = camera().project(side(3).inverse() * pipe.to);
  EXPECT_NEAR(std::max(view->from.x(), view->to.x()), end->x(), 1e-6);
  pipe.to.x() = 2;
  EXPECT_FALSE(view_pipe(pipe, camera(), side(3)));
}

TEST(PipeView, NothingBehindOrOutside) {
  EXPECT_FALSE(view_pipe(kPipe, camera(), T_body_side_camera({5, 20, 3}, 0)));
  EXPECT_FALSE(view_pipe(kPipe, camera(), side(9)));
  EXPECT_FALSE(view_pipe(kPipe, camera(), T_body_side_camera({5, 10, 3}, 0)));
}

}  // namespace
}  // namespace pipescout::simulation
