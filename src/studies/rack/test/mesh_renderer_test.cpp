// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/mesh_renderer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "pipescout/rack_study/paper_flight.hpp"
#include "pipescout/rack_vision/visual_servo.hpp"

namespace pipescout::rack_study {
namespace {

geometry::SE3 above(double x, double y, double z) {
  return geometry::SE3(rack_vision::downward_camera().rotation(), {x, y, z}).inverse();
}

std::vector<std::uint8_t> image_of(const MeshScene& scene, const geometry::SE3& T_camera_rack) {
  const geometry::Camera camera;
  MeshRenderer renderer(scene, camera);
  std::vector<std::uint8_t> grey(720 * 480);
  renderer.render(T_camera_rack, 1, grey);
  return grey;
}

TEST(MeshRenderer, IsRepeatable) {
  const MeshScene scene{.model = parallel_rack(4), .seed = 3};
  const geometry::SE3 pose = above(0.7, 5, 3);
  const auto once = image_of(scene, pose);
  EXPECT_EQ(once, image_of(scene, pose));
  EXPECT_NE(once, image_of({.model = parallel_rack(4), .seed = 4}, pose));
}

// From straight above the axis of a pipe both contours are asin(r / h) to its sides.
TEST(MeshRenderer, HasTheContoursOfAPipeWhereTheyAre) {
  const rack_vision::RackModel rack = parallel_rack(2);
  const rack_vision::Pipe& pipe = rack.pipes[1];
  const double radius = pipe.largest_radius();
  constexpr double kHeight = 2.5;  // m, over the axis
  const MeshScene scene{.model = rack, .contrast = 0, .noise = 0, .seed = 5};
  const auto grey = image_of(scene, above(pipe.start.x(), 5, pipe.start.z() + kHeight));
  const geometry::CameraParameters camera;
  const double half = camera.focal_length * std::tan(std::asin(radius / kHeight));
  // Rack x points up in this image. Above the pipe there is nothing beside it: the steepest place
  // of the column in the middle.
  const auto grey_at = [&grey](int v) { return grey[static_cast<std::size_t>(v * 720 + 360)]; };
  const int expected = static_cast<int>(std::lround(camera.centre_v - half));
  int steepest = 0;
  int at = 0;
  for (int v = expected - 2; v <= expected + 2; ++v) {
    const int step = std::abs(grey_at(v + 1) - grey_at(v - 1));
    if (step > steepest) {
      steepest = step;
      at = v;
    }
  }
  EXPECT_GT(steepest, 20);
  EXPECT_NEAR(at, camera.centre_v - half, 1.01);
}

TEST(MeshRenderer, RefusesWhatIsNotValid) {
  EXPECT_THROW(MeshRenderer({.model = parallel_rack(2), .contrast = -1}, geometry::Camera()),
               std::invalid_argument);
  geometry::CameraParameters distorted;
  distorted.k1 = -0.1;
  EXPECT_THROW(MeshRenderer({.model = parallel_rack(2)}, geometry::Camera(distorted)),
               std::invalid_argument);
  MeshRenderer renderer({.model = parallel_rack(2)}, geometry::Camera());
  std::vector<std::uint8_t> small(10);
  EXPECT_THROW(renderer.render(above(0, 5, 3), 1, small), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::rack_study
