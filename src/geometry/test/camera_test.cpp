// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/camera.hpp"

#include <gtest/gtest.h>

namespace pipescout::geometry {
namespace {

TEST(Camera, ProjectsAsEquationOne) {
  const Camera camera(CameraParameters{.focal_length = 600, .aspect_ratio = 1.1, .skew = 2});
  const auto pixel = camera.project({0.5, -0.25, 2});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 600 * 0.25 + 2 * -0.125 + 360, 1e-12);
  EXPECT_NEAR(pixel->y(), 1.1 * 600 * -0.125 + 240, 1e-12);
}

}  // namespace
}  // namespace pipescout::geometry
