// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/image_noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "drawn_rack.hpp"

namespace pipescout::rack_vision {
namespace {

using test::DrawnImage;

/// Two halves of different brightness, noise of `deviation(level)`.
template <typename Deviation>
DrawnImage two_levels(double left, double right, const Deviation& deviation, unsigned seed) {
  DrawnImage image{360, 240, std::vector<std::uint8_t>(360 * 240)};
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const double level = u < image.width / 2 ? left : right;
      image.pixels[static_cast<std::size_t>(v * image.width + u)] = static_cast<std::uint8_t>(
          std::clamp(std::lround(level + deviation(level) * normal(engine)), 0L, 255L));
    }
  }
  return image;
}

class NoiseOf : public ::testing::TestWithParam<double> {};

TEST_P(NoiseOf, APlainImageIsMeasured) {
  const double sigma = GetParam();
  const DrawnImage image = two_levels(
      110, 140, [&](double) { return sigma; }, 3);
  ImageNoise noise;
  noise.measure(image.view());
  for (const double level : {0.0, 100.0, 140.0, 255.0}) {
    EXPECT_NEAR(noise.sigma(level), sigma, 0.1 * sigma + 0.2) << level;
  }
}

TEST_P(NoiseOf, ATexturedRackIsMeasuredWithinAThird) {
  const double sigma = GetParam();
  const DrawnImage image = test::noisy(
      test::draw(test::drawn_rack(), test::drawn_camera(), test::drawn_pose(0.78, 4, 2.8, 0.1)),
      sigma, 5);
  ImageNoise noise;
  noise.measure(image.view());
  for (const double level : {70.0, 130.0}) {
    EXPECT_GT(noise.sigma(level), 0.8 * sigma) << level;
    EXPECT_LT(noise.sigma(level), 1.33 * sigma + 1.0) << level;
  }
}

INSTANTIATE_TEST_SUITE_P(ImageNoise, NoiseOf, ::testing::Values(0.0, 1.0, 3.0, 10.0, 25.0));

TEST(ImageNoise, DependsOnTheLevelAsPhotonsHaveIt) {
  const auto shot = [](double level) { return std::sqrt(level); };
  const DrawnImage image = two_levels(40, 200, shot, 7);
  ImageNoise noise;
  noise.measure(image.view());
  EXPECT_NEAR(noise.sigma(48), shot(40), 0.1 * shot(40));
  EXPECT_NEAR(noise.sigma(208), shot(200), 0.1 * shot(200));
}

TEST(ImageNoise, UpToTheNominalOneChangesNothing) {
  const DrawnImage image = two_levels(
      90, 150, [](double) { return 1.7; }, 9);
  ImageNoise noise;
  noise.measure(image.view());
  EXPECT_EQ(noise.excess(90), 0);
  EXPECT_EQ(noise.texture_contrast(3, 150), 3);
}

TEST(ImageNoise, AllOfItCountsWellAboveTheNominalOne) {
  const DrawnImage image = two_levels(
      90, 150, [](double) { return 6.0; }, 9);
  ImageNoise noise;
  noise.measure(image.view());
  EXPECT_EQ(noise.excess(90), noise.sigma(90));
  EXPECT_NEAR(noise.texture_contrast(3, 90), 12, 1.2);
}

TEST(ImageNoise, OfNoImageIsNone) {
  ImageNoise noise;
  noise.measure({});
  EXPECT_EQ(noise.sigma(100), 0);
  const DrawnImage white = two_levels(
      255, 255, [](double) { return 0.0; }, 1);
  noise.measure(white.view());
  EXPECT_EQ(noise.sigma(255), 0);
}

}  // namespace
}  // namespace pipescout::rack_vision
