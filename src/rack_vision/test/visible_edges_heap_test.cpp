// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "heap_guard.hpp"
#include "pipescout/rack_vision/surface_points.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"
#include "rack_scenes.hpp"

namespace pipescout::rack_vision {
namespace {

TEST(VisibleEdgesHeap, RenderingTakesNothingOnceItIsWarm) {
  const RackModel model = test::small_rack();
  geometry::CameraParameters parameters;
  parameters.k1 = -0.2;
  const geometry::Camera camera(parameters);
  const std::vector<double> offsets{0, 0.01, -0.01, 0.02, 0};
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  edges.reserve(200);
  test::Engine engine(7);
  std::vector<geometry::SE3> poses;
  for (int i = 0; i < 100; ++i) {
    poses.push_back(test::random_pose(engine));
  }
  const pipescout::test::HeapGuard guard;
  std::size_t most = 0;
  for (const geometry::SE3& pose : poses) {
    renderer.render(model, offsets, camera, pose, edges);
    most = std::max(most, edges.size());
  }
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_GT(most, 20U);
}

TEST(SurfacePointsHeap, RaysAndUpdatesOfTheSameRackTakeNothing) {
  const RackModel model = test::small_rack();
  const std::vector<double> offsets{0, 0.01, -0.01, 0.02, 0};
  const geometry::Camera camera;
  const geometry::SE3 pose = test::looking_at({0.8, 4, 3}, {0.8, 5, 0});
  RackSurface surface(model, {});
  int hits = 0;
  const pipescout::test::HeapGuard guard;
  surface.update(model, offsets);
  for (int u = 0; u < 720; u += 90) {
    if (const auto hit = surface.seen_at(camera, pose, {u, 240})) {
      hits += surface.visible_at(hit->point, hit->normal, camera, pose).has_value() ? 1 : 0;
    }
  }
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_GT(hits, 3);
}

}  // namespace
}  // namespace pipescout::rack_vision
