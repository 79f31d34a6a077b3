// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/surface_points.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "rack_scenes.hpp"

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A pipe on the y axis with a reducer from 2 to 3 m and a step at 5 m, another pipe beside it, and
/// a beam below both.
RackModel rack() {
  RackModel model;
  model.pipes.push_back({.name = "first",
                         .radii = {{0, 0.2}, {2, 0.2}, {3, 0.4}, {5, 0.4}, {5, 0.1}, {6, 0.1}},
                         .movable = false});
  model.pipes.push_back({.name = "second", .start = {2, 0, 0}, .radii = {{0, 0.2}, {6, 0.2}}});
  model.supports.push_back({"beam", {-1, 1, -0.5}, {3, 1.5, -0.2}});
  model.validate();
  return model;
}

const Vector3d kDown(0, 0, -1);

TEST(RackSurface, RaysMeetACylinderWhereTheCircleIs) {
  const RackSurface surface(rack(), {});
  const auto hit = surface.first_hit({0.1, 1, 3}, 7 * kDown);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->kind, EdgeKind::kPipe);
  EXPECT_EQ(hit->body, 0);
  EXPECT_EQ(hit->part, 0);
  EXPECT_TRUE(hit->on_side_of_pipe);
  const double top = std::sqrt(0.2 * 0.2 - 0.1 * 0.1);
  EXPECT_NEAR((hit->point - Vector3d(0.1, 1, top)).norm(), 0, 1e-12);
  EXPECT_NEAR((hit->normal - Vector3d(0.5, 0, top / 0.2)).norm(), 0, 1e-12);
  EXPECT_NEAR(hit->distance, 3 - top, 1e-12);
}

TEST(RackSurface, RaysMeetAReducerWhereTheConeIs) {
  const RackSurface surface(rack(), {});
  const auto hit = surface.first_hit({0, 2.5, 3}, kDown);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->part, 1);
  EXPECT_NEAR((hit->point - Vector3d(0, 2.5, 0.3)).norm(), 0, 1e-12);
  EXPECT_NEAR((hit->normal - Vector3d(0, -0.2, 1).normalized()).norm(), 0, 1e-12);
}

TEST(RackSurface, RaysMeetTheFlatEndAndTheRingOfAStep) {
  const RackSurface surface(rack(), {});
  const auto end = surface.first_hit({0.1, -2, 0}, Vector3d::UnitY());
  ASSERT_TRUE(end);
  EXPECT_FALSE(end->on_side_of_pipe);
  EXPECT_NEAR((end->point - Vector3d(0.1, 0, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(end->normal, Vector3d(0, -1, 0));
  const auto ring = surface.first_hit({0.3, 8, 0}, -Vector3d::UnitY());
  ASSERT_TRUE(ring);
  EXPECT_FALSE(ring->on_side_of_pipe);
  EXPECT_EQ(ring->part, 2);
  EXPECT_NEAR(ring->point.y(), 5, 1e-12);
  EXPECT_EQ(ring->normal, Vector3d(0, 1, 0));
}

TEST(RackSurface, RaysMeetSupportsBetweenThePipes) {
  const RackSurface surface(rack(), {});
  const auto hit = surface.first_hit({1, 1.2, 3}, kDown);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->kind, EdgeKind::kSupport);
  EXPECT_FALSE(hit->on_side_of_pipe);
  EXPECT_NEAR((hit->point - Vector3d(1, 1.2, -0.2)).norm(), 0, 1e-12);
  EXPECT_EQ(hit->normal, Vector3d(0, 0, 1));
}

TEST(RackSurface, OffsetsMoveThePipes) {
  const RackModel model = rack();
  const std::vector<double> offsets{0, 0.5};
  const RackSurface surface(model, offsets);
  const auto hit = surface.first_hit({2.5, 1, 3}, kDown);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->body, 1);
  EXPECT_NEAR(hit->point.z(), 0.2, 1e-12);
}

TEST(RackSurface, RaysThatPassMeetNothing) {
  const RackSurface surface(rack(), {});
  EXPECT_FALSE(surface.first_hit({1, 4, 3}, kDown));
  EXPECT_FALSE(surface.first_hit({0, 1, 3}, -kDown));
  EXPECT_FALSE(surface.first_hit({0.5, -5, 0}, Vector3d::UnitY()));
  EXPECT_FALSE(surface.first_hit({0, 7, 0.05}, Vector3d::UnitX()));
  EXPECT_FALSE(RackSurface().first_hit({0, 0, 3}, kDown));
}

TEST(RackSurface, RaysFromWithinABodyMeetItAtOnce) {
  const RackSurface surface(rack(), {});
  for (const Vector3d& origin : {Vector3d(0.05, 1, 0.05), Vector3d(1, 1.2, -0.4)}) {
    const auto hit = surface.first_hit(origin, Vector3d(1, 2, 3));
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->distance, 0);
    EXPECT_LT(hit->normal.dot(Vector3d(1, 2, 3)), 0);
  }
}

TEST(RackSurface, BadRaysMeetNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const RackSurface surface(rack(), {});
  EXPECT_FALSE(surface.first_hit({0, 1, 3}, Vector3d::Zero()));
  EXPECT_FALSE(surface.first_hit({0, 1, 3}, {0, nan, -1}));
  EXPECT_FALSE(surface.first_hit({0, 1, 3}, {0, 0, -infinity}));
  EXPECT_FALSE(surface.first_hit({nan, 1, 3}, kDown));
}

TEST(RackSurface, RefusesOffsetsThatDoNotFit) {
  RackSurface surface;
  const std::vector<double> one{0};
  EXPECT_THROW(surface.update(rack(), one), std::invalid_argument);
  const std::vector<double> infinite{0, std::numeric_limits<double>::infinity()};
  EXPECT_THROW(surface.update(rack(), infinite), std::invalid_argument);
}

TEST(RackSurface, VisiblePointsFaceTheCameraWithinTheImage) {
  const RackSurface surface(rack(), {});
  const geometry::Camera camera;
  const geometry::SE3 pose = test::looking_at({0, 1, 3}, {0, 1, 0});
  const Vector3d up = Vector3d::UnitZ();
  const auto pixel = surface.visible_at({0, 1, 0.2}, up, camera, pose);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR((*pixel - Vector2d(360, 240)).norm(), 0, 1e-9);
  EXPECT_FALSE(surface.visible_at({0, 1, -0.2}, kDown, camera, pose)) << "turned away";
  EXPECT_FALSE(surface.visible_at({0, 1, -0.2}, up, camera, pose)) << "behind its own pipe";
  EXPECT_FALSE(surface.visible_at({0, 5.5, 0.1}, up, camera, pose)) << "outside the image";
  EXPECT_FALSE(surface.visible_at({0, 1, 0.2}, up, camera, pose, 241)) << "in the margin";
  const Vector3d slanting(std::sqrt(0.75), 0, 0.5);
  EXPECT_TRUE(surface.visible_at({0, 1, 0.2}, slanting, camera, pose, 0, 0.49));
  EXPECT_FALSE(surface.visible_at({0, 1, 0.2}, slanting, camera, pose, 0, 0.51)) << "grazing";
  EXPECT_TRUE(surface.visible_at({1, 1.2, -0.2}, up, camera, pose));
  EXPECT_FALSE(surface.visible_at({0, 1.2, -0.2}, up, camera, pose)) << "behind the first pipe";
}

/// The gradient of a function of a point, by differences.
template <typename Function>
Vector3d gradient(Function function, const Vector3d& at) {
  Vector3d result;
  for (int i = 0; i < 3; ++i) {
    const Vector3d step = 1e-6 * Vector3d::Unit(i);
    result[i] = (function(at + step) - function(at - step)) / 2e-6;
  }
  return result;
}

TEST(RackSurface, AgreesWithWalkingAlongRandomRays) {
  int hits = 0;
  int misses = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    test::Engine engine(seed);
    const RackModel model = test::random_rack(engine);
    const RackSurface surface(model, {});
    for (int ray = 0; ray < 20; ++ray) {
      const Vector3d origin = test::eye_of(test::random_pose(engine));
      const Vector3d target(test::uniform(engine, -0.5, 2.5), test::uniform(engine, 0, 6),
                            test::uniform(engine, -0.2, 0.8));
      const Vector3d far = origin + 20 * (target - origin).normalized();
      const auto hit = surface.first_hit(origin, target - origin);
      if (!hit) {
        ++misses;
        EXPECT_GT(test::smallest_clearance(model, origin, far, -1, -1, -1), -1e-6);
        continue;
      }
      if (hit->distance == 0) {
        continue;
      }
      ++hits;
      EXPECT_NEAR((hit->point - origin).norm(), hit->distance, 1e-9);
      EXPECT_NEAR(test::smallest_clearance(model, origin, hit->point, -1, -1, -1), 0, 1e-6);
      EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
      EXPECT_LT(hit->normal.dot(target - origin), 0);
      const auto outside = [&](const Vector3d& point) {
        return hit->kind == EdgeKind::kPipe
                   ? test::outside_of(test::sections_of(model, hit->body)[hit->part], point)
                   : test::outside_of(model.supports[hit->body], point);
      };
      EXPECT_NEAR(outside(hit->point), 0, 1e-9);
      EXPECT_GT(gradient(outside, hit->point).normalized().dot(hit->normal), 1 - 1e-6);
    }
  }
  EXPECT_GT(hits, 400);
  EXPECT_GT(misses, 100);
}

TEST(RackSurface, WhatIsSeenAtAPixelIsVisibleAtThatPixel) {
  geometry::CameraParameters parameters;
  parameters.k1 = -0.2;
  parameters.p1 = 0.001;
  const geometry::Camera camera(parameters);
  int seen = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    test::Engine engine(seed);
    const RackModel model = test::random_rack(engine);
    const RackSurface surface(model, {});
    const geometry::SE3 pose = test::random_pose(engine);
    for (int i = 0; i < 20; ++i) {
      const Vector2d pixel(test::uniform(engine, 1, 718), test::uniform(engine, 1, 478));
      const auto hit = surface.seen_at(camera, pose, pixel);
      if (!hit || hit->distance < 0.01) {
        continue;
      }
      ++seen;
      const auto again = surface.visible_at(hit->point, hit->normal, camera, pose);
      ASSERT_TRUE(again);
      EXPECT_NEAR((*again - pixel).norm(), 0, 1e-6);
    }
  }
  EXPECT_GT(seen, 400);
}

}  // namespace
}  // namespace pipescout::rack_vision
