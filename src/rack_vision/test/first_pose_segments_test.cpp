// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/first_pose_segments.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector2d;
using geometry::Camera;
using geometry::CameraParameters;

/// Dark on one side of a line of the ideal image, bright on the other, as this camera sees it:
/// `normal` . ideal pixel > offset is bright. Each pixel is the mean of 64 places.
std::vector<std::uint8_t> step_image(const Camera& camera, const Vector2d& normal, double offset,
                                     double dark, double bright) {
  const int width = camera.parameters().width;
  const int height = camera.parameters().height;
  std::vector<std::uint8_t> image;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Vector2d ideal = camera.undistort(Vector2d(u, v)).value_or(Vector2d(u, v));
      int above = std::abs(normal.dot(ideal) - offset) > 3 && normal.dot(ideal) > offset ? 64 : 0;
      for (int i = 0; i < 64 && std::abs(normal.dot(ideal) - offset) <= 3; ++i) {
        const Vector2d place(u + (i % 8 - 3.5) / 8, v + (i / 8 - 3.5) / 8);
        above += normal.dot(camera.undistort(place).value_or(ideal)) > offset ? 1 : 0;
      }
      image.push_back(static_cast<std::uint8_t>(
          std::lround(dark + (bright - dark) * static_cast<double>(above) / 64)));
    }
  }
  return image;
}

ImageView view_of(const std::vector<std::uint8_t>& image, const Camera& camera) {
  return {image.data(), camera.parameters().width, camera.parameters().height,
          camera.parameters().width};
}

TEST(ExtractSegments, FindsAnEdgeToATenthOfAPixelWithAndWithoutDistortion) {
  for (const CameraParameters& parameters :
       {CameraParameters{}, CameraParameters{.k1 = -0.12, .k2 = 0.04}}) {
    const Camera camera(parameters);
    for (const double angle : {0.0, 0.3, 1.2, 2.5, 4.0}) {
      const Vector2d normal(std::cos(angle), std::sin(angle));
      const double offset = normal.dot(Vector2d(333.3, 261.7));
      const auto image = step_image(camera, normal, offset, 60, 140);
      const auto segments = extract_segments(view_of(image, camera), camera);
      ASSERT_FALSE(segments.empty());
      double length = 0;
      for (const ImageSegment& segment : segments) {
        EXPECT_NEAR(normal.dot(segment.start), offset, 0.1) << angle;
        EXPECT_NEAR(normal.dot(segment.end), offset, 0.1) << angle;
        const Vector2d along = segment.end - segment.start;
        EXPECT_GT(normal.dot(Vector2d(-along.y(), along.x())), 0) << "the right side is bright";
        EXPECT_GT(segment.contrast, 40);
        EXPECT_LT(segment.contrast, 81);
        length += along.norm();
      }
      EXPECT_GT(length, 350);
      EXPECT_LE((segments.back().end - segments.back().start).norm(),
                (segments.front().end - segments.front().start).norm());
    }
  }
}

TEST(ExtractSegments, FindsNothingInPlainImages) {
  const Camera camera;
  for (const int level : {0, 128, 255}) {
    const std::vector<std::uint8_t> image(720 * 480, static_cast<std::uint8_t>(level));
    EXPECT_TRUE(extract_segments(view_of(image, camera), camera).empty());
  }
}

TEST(ExtractSegments, KeepsNoMoreThanAskedFor) {
  const Camera camera;
  std::vector<std::uint8_t> image;
  for (int i = 0; i < 720 * 480; ++i) {
    image.push_back((i % 720) / 40 % 2 == 0 ? 40 : 200);
  }
  EXPECT_GE(extract_segments(view_of(image, camera), camera).size(), 17U);
  EXPECT_EQ(extract_segments(view_of(image, camera), camera, {.most = 5}).size(), 5U);
}

TEST(ExtractSegments, RefusesBadArguments) {
  const Camera camera;
  const std::vector<std::uint8_t> image(720 * 480, 7);
  EXPECT_THROW(static_cast<void>(extract_segments({}, camera)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(extract_segments({image.data(), 640, 480, 640}, camera)),
               std::invalid_argument);
  EXPECT_THROW(static_cast<void>(extract_segments({image.data(), 720, 480, 700}, camera)),
               std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const SegmentParameters& bad :
       {SegmentParameters{.shortest = 2}, SegmentParameters{.smallest_contrast = 0},
        SegmentParameters{.blur = nan}, SegmentParameters{.most = 0}}) {
    EXPECT_THROW(static_cast<void>(extract_segments(view_of(image, camera), camera, bad)),
                 std::invalid_argument);
  }
}

}  // namespace
}  // namespace pipescout::rack_vision
