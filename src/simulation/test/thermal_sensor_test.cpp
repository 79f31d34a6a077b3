// SPDX-License-Identifier: Apache-2.0
// Noise, blur and dead pixels of the thermal camera.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <vector>

#include "thermal_views.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;
using test::bare_scene;
using test::level_view;
using test::perfect_camera;
using test::ThermalImage;

std::vector<ThermalImage> frames_of(ThermalRenderer& renderer, int count) {
  std::vector<ThermalImage> images;
  ThermalView view = level_view(20, 6);  // nothing but the wall
  for (int i = 0; i < count; ++i) {
    view.frame = static_cast<std::uint64_t>(i);
    images.emplace_back(renderer, view);
  }
  return images;
}

TEST(ThermalNoise, IsWhiteAndOfTheStatedNetd) {
  ThermalCameraParameters camera = perfect_camera();
  camera.netd = 0.1;
  ThermalRenderer renderer(ThermalScene(bare_scene()), camera);
  const auto images = frames_of(renderer, 6);
  const double slope = camera.constants.planck.slope(30);
  double mean = 0;
  for (const std::uint16_t each : images[0].counts()) {
    mean += each;
  }
  mean /= static_cast<double>(images[0].counts().size());
  // Covariances of neighbours: along a row, from row to row, from frame to frame.
  double variance = 0;
  double along = 0;
  double across = 0;
  double in_time = 0;
  double count = 0;
  for (std::size_t i = 0; i + 1 < images.size(); ++i) {
    for (int y = 0; y < 239; ++y) {
      for (int x = 0; x < 319; ++x, ++count) {
        const double here = images[i](x, y) - mean;
        variance += here * here;
        along += here * (images[i](x + 1, y) - mean);
        across += here * (images[i](x, y + 1) - mean);
        in_time += here * (images[i + 1](x, y) - mean);
      }
    }
  }
  // Rounding to whole counts adds 1 / 12.
  EXPECT_NEAR(std::sqrt(variance / count - 1.0 / 12) / slope, 0.1, 0.002);
  const double four_deviations = 4 / std::sqrt(count);
  EXPECT_LT(std::abs(along / variance), four_deviations);
  EXPECT_LT(std::abs(across / variance), four_deviations);
  EXPECT_LT(std::abs(in_time / variance), four_deviations);
}

TEST(ThermalNoise, HasAPartThatStays) {
  ThermalCameraParameters camera = perfect_camera();
  camera.netd = 0.08;
  camera.fixed_pattern = 0.5;
  ThermalRenderer renderer(ThermalScene(bare_scene()), camera);
  const auto images = frames_of(renderer, 2);
  double product = 0;
  double mean = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      mean += (images[0](x, y) + images[1](x, y)) / 2;
    }
  }
  mean /= 320 * 240;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      product += (images[0](x, y) - mean) * (images[1](x, y) - mean);
    }
  }
  const double fixed = std::sqrt(product / (320 * 240)) / camera.constants.planck.slope(30);
  // Half of its variance is that of 320 columns only.
  EXPECT_NEAR(fixed, 0.04, 0.004);
}

TEST(ThermalNoise, IsTheSameForTheSameFrameAndSeed) {
  ThermalCameraParameters camera = ThermalCameraParameters::qvga();
  const ThermalScene scene(ThermalSceneParameters{});
  ThermalRenderer first(scene, camera);
  ThermalRenderer again(scene, camera);
  camera.seed = 2;
  ThermalRenderer other(scene, camera);
  ThermalView view = level_view(20);
  view.frame = 7;
  const ThermalImage image(first, view);
  EXPECT_EQ(image.counts(), ThermalImage(again, view).counts());
  EXPECT_NE(image.counts(), ThermalImage(other, view).counts());
  view.frame = 8;
  EXPECT_NE(image.counts(), ThermalImage(first, view).counts());
  view.frame = 7;
  EXPECT_EQ(image.counts(), ThermalImage(first, view).counts());
}

TEST(ThermalNoise, DeadPixelsShowTheSameWhateverThereIs) {
  ThermalCameraParameters camera = perfect_camera();
  camera.dead_share = 0.01;
  ThermalRenderer renderer(ThermalScene(bare_scene()), camera);
  const ThermalImage wall(renderer, level_view(20, 6));
  const ThermalImage tube(renderer, level_view(20));
  const double shown = wall(1, 1);
  std::size_t dead = 0;
  for (std::size_t i = 0; i < wall.counts().size(); ++i) {
    if (std::abs(wall.counts()[i] - shown) > 1) {
      ++dead;
      EXPECT_EQ(wall.counts()[i], tube.counts()[i]);
    }
  }
  // Some are drawn twice.
  EXPECT_GT(dead, 740U);
  EXPECT_LE(dead, 768U);
}

/// Steps from pixel to pixel gather what lies between: by Sheppard, that adds so much to a
/// variance, on average over where the edge lies between two pixels.
constexpr double kOfSteps = 1.0 / 12;
constexpr double kOfPixel = 1.0 / 12;
constexpr int kPhases = 10;

/// Variance, in pixels squared, of how the counts come up along a line of pixels.
template <class Counts>
double edge_variance(int from, int to, Counts counts) {
  double sum = 0;
  double moment = 0;
  double second = 0;
  for (int i = from; i < to; ++i) {
    const double step = counts(i + 1) - counts(i);
    sum += step;
    moment += step * i;
    second += step * i * i;
  }
  const double mean = moment / sum;
  return second / sum - mean * mean;
}

TEST(ThermalBlur, AlongTheTubeIsTheWayDuringTheExposure) {
  ThermalSceneParameters parameters = bare_scene();
  // A single sharp edge in view.
  parameters.leaks = {{.place = 10, .length = 20, .rise = 50, .shoulder = 0}};
  ThermalCameraParameters camera = perfect_camera();
  camera.exposure = 0.01;
  for (const double lens : {0.0, 1.0}) {
    camera.lens_blur = lens;
    ThermalRenderer renderer(ThermalScene(parameters), camera);
    const double focal_length = renderer.camera().parameters().focal_length;
    for (const double speed : {0.0, 5.0, 12.0}) {
      const double path = speed * 0.01 * focal_length / 10;  // pixels
      double variance = 0;
      for (int phase = 0; phase < kPhases; ++phase) {
        ThermalView view = level_view(20 + phase * 10 / (kPhases * focal_length));
        view.velocity.head<3>() = Vector3d(speed, 0, 0);
        const ThermalImage image(renderer, view);
        variance += edge_variance(60, 260, [&](int x) { return image(x, 120); }) / kPhases;
      }
      // The tube is interpolated between 2048 samples over the view.
      const double of_samples = std::pow(320.0 / 2048, 2) / 6;
      const double expected = path * path / 12 + lens * lens + kOfPixel + kOfSteps + of_samples;
      EXPECT_NEAR(variance, expected, 0.02 * expected) << speed << " m/s, " << lens;
    }
  }
}

TEST(ThermalBlur, OfTurningIsAsThatOfMoving) {
  ThermalSceneParameters parameters = bare_scene();
  parameters.leaks = {{.place = 10, .length = 20, .rise = 50, .shoulder = 0}};
  ThermalCameraParameters camera = perfect_camera();
  camera.exposure = 0.01;
  ThermalRenderer renderer(ThermalScene(parameters), camera);
  ThermalView moving = level_view(20);
  moving.velocity.head<3>() = Vector3d(8, 0, 0);
  // Turning to the right at 0.8 rad/s is what going 8 m/s is at 10 m.
  ThermalView turning = level_view(20);
  turning.velocity.tail<3>() = Vector3d(0, 0.8, 0);
  const ThermalImage moved(renderer, moving);
  const ThermalImage turned(renderer, turning);
  for (int x = 100; x < 220; ++x) {
    EXPECT_NEAR(moved(x, 120), turned(x, 120), 15);
  }
}

TEST(ThermalBlur, AcrossTheTubeIsTheWayOfItsImage) {
  ThermalSceneParameters parameters = bare_scene();
  parameters.tube_radius = 0.3;
  ThermalCameraParameters camera = perfect_camera();
  camera.exposure = 0.01;
  ThermalRenderer renderer(ThermalScene(parameters), camera);
  for (const double rate : {0.0, 0.4, 1.0}) {
    const double focal_length = renderer.camera().parameters().focal_length;
    const double path = rate * 0.01 * focal_length;
    double variance = 0;
    for (int phase = 0; phase < kPhases; ++phase) {
      ThermalView view = level_view(20, 3 + phase * 10 / (kPhases * focal_length));
      view.velocity.tail<3>() = Vector3d(rate, 0, 0);
      const ThermalImage image(renderer, view);
      variance += edge_variance(60, 119, [&](int y) { return image(160, y); }) / kPhases;
    }
    const double expected = path * path / 12 + kOfPixel + kOfSteps;
    EXPECT_NEAR(variance, expected, 0.03 * expected) << rate;
  }
}

}  // namespace
}  // namespace pipescout::simulation
