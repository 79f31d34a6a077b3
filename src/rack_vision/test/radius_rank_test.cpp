// SPDX-License-Identifier: Apache-2.0
#include "radius_rank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace pipescout::rack_vision {
namespace {

constexpr int kWidth = 360;
constexpr int kHeight = 240;
constexpr double kMiddle = 180.3;  // px, of the pipe, which runs down the image
constexpr double kHalfWidth = 50;  // px

geometry::Camera camera() {
  geometry::CameraParameters parameters;
  parameters.width = kWidth;
  parameters.height = kHeight;
  return geometry::Camera(parameters);
}

/// One pipe, `contrast` grey levels brighter than the ground, with a texture that is as strong on
/// both; all of it in noise.
struct Image {
  std::vector<std::uint8_t> pixels;

  Image(double contrast, double texture, double noise) {
    std::mt19937 engine(3);
    std::normal_distribution<double> normal(0, noise);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const double step = std::clamp(kHalfWidth - std::abs(u - kMiddle) + 0.5, 0.0, 1.0);
        const double grey = 90 + contrast * step +
                            texture * std::sin(0.71 * u + 0.4 * v) * std::cos(0.53 * v - 0.2 * u) +
                            normal(engine);
        pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L)));
      }
    }
  }
  [[nodiscard]] ImageView view() const { return {pixels.data(), kWidth, kHeight, kWidth}; }
};

/// The contours of a pipe at `middle`, px, in two pieces on the left.
std::vector<AlignmentContour> contours(double middle, double half_width, double length = 200) {
  const auto contour = [](double u, double from, double to, double outwards) {
    AlignmentContour result;
    result.start = {u, from};
    result.end = {u, to};
    result.normal = {outwards, 0};
    return result;
  };
  return {contour(middle - half_width, 20, 20 + 0.4 * length, -1),
          contour(middle - half_width, 20 + 0.5 * length, 20 + length, -1),
          contour(middle + half_width, 20, 20 + length, 1)};
}

TEST(RadiusRank, ThePipesOwnRadiusIsTheBest) {
  RadiusRank rank(camera());
  for (const double contrast : {-60.0, 15.0, 80.0}) {
    const Image image(contrast, 20, 2);
    for (const double aside : {-1.5, 0.0, 1.5}) {
      const auto share = rank.share_of_better(image.view(), contours(kMiddle + aside, kHalfWidth));
      ASSERT_TRUE(share) << contrast;
      EXPECT_LT(*share, 0.03) << contrast << " " << aside;
    }
  }
}

TEST(RadiusRank, NoiseAloneDoesNotHideIt) {
  RadiusRank rank(camera());
  const auto share = rank.share_of_better(Image(40, 0, 25).view(), contours(kMiddle, kHalfWidth));
  ASSERT_TRUE(share);
  EXPECT_LT(*share, 0.03);
}

TEST(RadiusRank, WithOneContourOnAnEdgeOthersAreAsGood) {
  RadiusRank rank(camera());
  const Image image(60, 40, 2);
  for (const double half_width : {30.0, 40.0, 65.0, 80.0}) {
    // Put so that its left contour lies on that of the pipe in the image.
    const double middle = kMiddle - kHalfWidth + half_width;
    const auto share = rank.share_of_better(image.view(), contours(middle, half_width));
    ASSERT_TRUE(share) << half_width;
    EXPECT_GE(*share, 0.1) << half_width;
  }
}

TEST(RadiusRank, WhereThereIsNoPipeMostOthersAreAsGood) {
  RadiusRank rank(camera());
  const auto share = rank.share_of_better(Image(0, 40, 2).view(), contours(kMiddle, kHalfWidth));
  ASSERT_TRUE(share);
  EXPECT_GT(*share, 0.5);
}

TEST(RadiusRank, SaysNothingOfPipesOfWhichTooLittleIsSeen) {
  RadiusRank rank(camera());
  const Image image(60, 20, 2);
  const std::vector<AlignmentContour> both = contours(kMiddle, kHalfWidth);
  EXPECT_FALSE(rank.share_of_better(image.view(), {}));
  EXPECT_FALSE(rank.share_of_better(image.view(), std::span(both).first(2)));
  EXPECT_FALSE(rank.share_of_better(image.view(), contours(kMiddle, kHalfWidth, 50)));
  EXPECT_FALSE(rank.share_of_better(image.view(), contours(kMiddle, 5)));
}

TEST(RadiusRank, ContoursAtAndBeyondTheBordersAreAllowed) {
  RadiusRank rank(camera());
  const Image image(60, 20, 2);
  for (const double middle : {-20.0, 0.0, 350.0, 380.0}) {
    const auto share = rank.share_of_better(image.view(), contours(middle, kHalfWidth));
    ASSERT_TRUE(share) << middle;
    EXPECT_GT(*share, 0) << middle;
    EXPECT_LE(*share, 1) << middle;
  }
}

}  // namespace
}  // namespace pipescout::rack_vision
