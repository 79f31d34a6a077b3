// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "pipescout/leak_findings/leak_findings.hpp"

namespace pipescout::leak_findings {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

geometry::CameraParameters camera_parameters() {
  geometry::CameraParameters camera;
  camera.width = 320;
  camera.height = 240;
  camera.focal_length = 280;
  camera.centre_u = 159.5;
  camera.centre_v = 119.5;
  return camera;
}

/// Two along y, the second of two radii, and one across them and higher.
std::vector<PipeLine> rack() {
  return {{{0, -5, 0.15}, {0, 5, 0.15}, 0.15},
          {{0.6, -5, 0.2}, {0.6, 0.1, 0.2}, 0.15},
          {{0.6, 0.1, 0.2}, {0.6, 5, 0.2}, 0.2},
          {{-3, 0.3, 0.56}, {3, 0.3, 0.56}, 0.16}};
}

/// Looking down, image up along y, and tilted.
SE3 T_map_camera() {
  Eigen::Matrix3d axes;
  axes << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  return {SO3::exp(Vector3d(0.12, -0.2, 0.1)) * SO3::from_matrix(axes), {0.4, 0.2, 2.6}};
}

Frame frame() {
  Frame frame;
  frame.time = 1;
  frame.pose = FramePose{.T_map_base = T_map_camera()};
  frame.pose->covariance.diagonal().setConstant(1e-4);
  return frame;
}

std::vector<thermal::PipeStrip> strips_of(
    const std::vector<PipeLine>& lines,
    const geometry::CameraParameters& camera = camera_parameters()) {
  LeakFindingsParameters p;
  p.range_source = RangeSource::kLine;
  p.lines = lines;
  return LeakFindings(p, geometry::Camera(camera)).conditions(frame()).strips;
}

/// m, between the ray of a pixel and the axis of a line.
double distance(const geometry::Camera& camera, const Vector2d& pixel, const PipeLine& line) {
  const Vector3d ray = T_map_camera().rotation() * camera.ray(pixel).value();
  const Vector3d normal = ray.cross((line.to - line.from).normalized()).normalized();
  return std::abs(normal.dot(line.from - T_map_camera().translation()));
}

TEST(PipeStrips, EdgesAreWhereRaysTouchTheSurface) {
  const std::vector<PipeLine> lines = rack();
  const geometry::Camera camera(camera_parameters());
  const auto strips = strips_of(lines);
  ASSERT_EQ(strips.size(), lines.size());
  for (std::size_t i = 0; i < strips.size(); ++i) {
    const thermal::PipeStrip& strip = strips[i];
    const Vector2d along = (strip.end - strip.start).normalized();
    const Vector2d aside(-along.y(), along.x());
    for (const double share : {0.0, 0.3, 0.5, 0.8, 1.0}) {
      const Vector2d middle = strip.start + share * (strip.end - strip.start);
      const double half_width = std::lerp(strip.half_width[0], strip.half_width[1], share);
      for (const double side : {-1.0, 1.0}) {
        EXPECT_NEAR(distance(camera, middle + side * half_width * aside, lines[i]), lines[i].radius,
                    0.004)
            << i << ' ' << share;
      }
    }
    const double length = (strip.end - strip.start).norm() * strip.metres_per_pixel;
    EXPECT_GT(length, i == 1 || i == 2 ? 0.5 : 1.5) << i;
    EXPECT_LT(length, 5) << i;
  }
}

TEST(PipeStrips, SectionsOfOnePipeBelongTogetherAndTheHigherOneIsNearer) {
  const auto strips = strips_of(rack());
  ASSERT_EQ(strips.size(), 4U);
  EXPECT_EQ(strips[0].pipe, 0U);
  EXPECT_EQ(strips[1].pipe, 1U);
  EXPECT_EQ(strips[2].pipe, 1U);
  EXPECT_EQ(strips[3].pipe, 2U);
  EXPECT_LT((strips[1].end - strips[2].start).norm(), 2);
  EXPECT_LT(strips[1].half_width[1] + 3, strips[2].half_width[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(std::min(strips[i].depth[0], strips[i].depth[1]),
              std::max(strips[3].depth[0], strips[3].depth[1]) - 0.4);
  }
}

TEST(PipeStrips, WhatIsOutOfViewOrBehindIsLeftOut) {
  std::vector<PipeLine> lines = rack();
  lines.push_back({{9, -5, 0}, {9, 5, 0}, 0.2});
  lines.push_back({{-5, 0, 4}, {5, 0, 4}, 0.2});          // above the camera
  lines.push_back({{0.4, 0.2, -1}, {0.4, 0.2, 5}, 0.1});  // up through it
  EXPECT_EQ(strips_of(lines).size(), 4U);
  // Axis out of view, and surface within.
  const Vector3d eye = T_map_camera().translation();
  const Vector3d ray =
      T_map_camera().rotation() * geometry::Camera(camera_parameters()).ray({0, 119.5}).value();
  const double border = eye.x() + ray.x() * (0.2 - eye.z()) / ray.z();
  EXPECT_EQ(strips_of({{{border - 0.2, -5, 0.2}, {border - 0.2, 5, 0.2}, 0.35}}).size(), 1U);
  EXPECT_TRUE(strips_of({{{border - 1, -5, 0.2}, {border - 1, 5, 0.2}, 0.35}}).empty());
}

TEST(PipeStrips, WithALensThatBendsTheyAreNearTheEdgesToo) {
  geometry::CameraParameters bent = camera_parameters();
  bent.k1 = -0.15;
  const std::vector<PipeLine> lines = rack();
  const auto strips = strips_of(lines, bent);
  ASSERT_EQ(strips.size(), lines.size());
  const geometry::Camera camera(bent);
  for (std::size_t i = 0; i < strips.size(); ++i) {
    const Vector2d middle = 0.5 * (strips[i].start + strips[i].end);
    EXPECT_LT(distance(camera, middle, lines[i]), 0.5 * lines[i].radius) << i;
  }
}

TEST(PipeStrips, ThereAreNoneWithoutGeometryOrPose) {
  std::vector<PipeLine> lines = rack();
  LeakFindingsParameters p;
  p.range_source = RangeSource::kLine;
  p.lines = lines;
  const geometry::Camera camera(camera_parameters());
  EXPECT_TRUE(LeakFindings(p, camera).conditions({.time = 1}).strips.empty());
  Frame unsound = frame();
  unsound.pose->covariance(0, 0) = -1;
  EXPECT_TRUE(LeakFindings(p, camera).conditions(unsound).strips.empty());
  // One would not be found that has no radius.
  lines.push_back({{1, -5, 0}, {1, 5, 0}, 0});
  EXPECT_TRUE(strips_of(lines).empty());
  p.range_source = RangeSource::kDistance;
  EXPECT_TRUE(LeakFindings(p, camera).conditions(frame()).strips.empty());
}

}  // namespace
}  // namespace pipescout::leak_findings
