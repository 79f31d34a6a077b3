// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "heap_guard.hpp"
#include "pipescout/simulation/contour_clutter.hpp"
#include "rack_image_scenes.hpp"

namespace pipescout::simulation {
namespace {

using test::GreyImage;

double bilinear(const GreyImage& image, const Eigen::Vector2d& pixel) {
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < image.width - 1 &&
        pixel.y() < image.height - 1)) {
    throw std::out_of_range("pixel outside the image");
  }
  const int u = static_cast<int>(std::floor(pixel.x()));
  const int v = static_cast<int>(std::floor(pixel.y()));
  const double fu = pixel.x() - u;
  const double fv = pixel.y() - v;
  return (1 - fv) * ((1 - fu) * image.at(u, v) + fu * image.at(u + 1, v)) +
         fv * ((1 - fu) * image.at(u, v + 1) + fu * image.at(u + 1, v + 1));
}

/// Points on the upper flank of a cylinder along y with its start at `start`.
std::vector<Eigen::Vector3d> flank(const Eigen::Vector3d& start, double radius, double from,
                                   double to) {
  std::vector<Eigen::Vector3d> points;
  for (double angle = -0.6; angle <= 0.6; angle += 0.02) {
    for (double along = from; along <= to; along += 0.004) {
      points.emplace_back(
          start + Eigen::Vector3d(radius * std::sin(angle), along, radius * std::cos(angle)));
    }
  }
  return points;
}

std::vector<double> sample(const GreyImage& image, const geometry::SE3& pose,
                           const std::vector<Eigen::Vector3d>& points,
                           const Eigen::Vector2d& shift = Eigen::Vector2d::Zero()) {
  std::vector<double> levels;
  for (const Eigen::Vector3d& point : points) {
    levels.push_back(bilinear(image, *geometry::Camera().project(pose * point) + shift));
  }
  return levels;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const Eigen::Map<const Eigen::ArrayXd> x(a.data(), static_cast<Eigen::Index>(a.size()));
  const Eigen::Map<const Eigen::ArrayXd> y(b.data(), static_cast<Eigen::Index>(b.size()));
  const Eigen::ArrayXd dx = x - x.mean();
  const Eigen::ArrayXd dy = y - y.mean();
  return (dx * dy).sum() / std::sqrt(dx.square().sum() * dy.square().sum());
}

RackScene textured_scene() {
  RackScene scene{.model = test::paper_rack()};
  scene.finishes.assign(4, {.albedo = 0.4, .rust = 0.3, .contrast = 1, .gloss = 0});
  return scene;
}

/// Light that no direction of view changes.
constexpr double kSky = 0.9;
RackLight even_light() {
  return {.sun = 0, .sky = kSky, .gain = 1, .offset = 5};
}

TEST(RackImageTexture, IsFixedToTheSurface) {
  RackScene scene = textured_scene();
  ImageSensor sensor = perfect_image_sensor();
  sensor.lens_blur = 0.7;
  RackImageRenderer renderer(scene, geometry::Camera(), sensor);
  const geometry::SE3 one = test::looking(true, {0.7, 3.9, 2.8});
  const geometry::SE3 other = test::looking(true, {1.1, 4.3, 2.5}, {0.1, -0.12, 0.4});
  const GreyImage first = test::render(renderer, {.T_camera_rack = one, .light = even_light()});
  const GreyImage second = test::render(renderer, {.T_camera_rack = other, .light = even_light()});
  for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
    const rack_vision::Pipe& pipe = scene.model.pipes[i];
    const auto points = flank(pipe.start, pipe.radii[0].radius, 3.9, 4.5);
    const std::vector<double> here = sample(first, one, points);
    const double there = correlation(here, sample(second, other, points));
    EXPECT_GT(there, 0.93) << pipe.name;
    // The best match is at the right place, to less than a tenth of a pixel.
    for (const double shift : {-0.5, 0.5}) {
      EXPECT_LT(correlation(here, sample(second, other, points, {shift, 0})), there);
      EXPECT_LT(correlation(here, sample(second, other, points, {0, shift})), there);
    }
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = Eigen::Vector2d::Unit(axis);
      const double before = correlation(here, sample(second, other, points, -step));
      const double after = correlation(here, sample(second, other, points, step));
      const double peak = 0.5 * (after - before) / (2 * there - before - after);
      EXPECT_LT(std::abs(peak), 0.1) << pipe.name << " axis " << axis;
    }
  }
}

TEST(RackImageTexture, DoesNotRepeatAlongThePipe) {
  RackScene scene = textured_scene();
  RackImageRenderer renderer(scene, geometry::Camera(), perfect_image_sensor());
  const rack_vision::Pipe& pipe = scene.model.pipes[1];
  std::vector<std::vector<double>> stretches;
  for (double y = 1; y < 9.5; y += 0.5) {
    const geometry::SE3 pose = test::looking(true, {pipe.start.x(), y, 2.5});
    const GreyImage image = test::render(renderer, {.T_camera_rack = pose, .light = even_light()});
    stretches.push_back(sample(image, pose, flank(pipe.start, 0.2, y - 0.25, y + 0.25)));
  }
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_LT(correlation(stretches[i], stretches[j]), 0.75) << i << " " << j;
    }
  }
}

TEST(RackImageTexture, IsNotThereOnPlainStretches) {
  RackScene scene = textured_scene();
  scene.plain = {{3.0, 5.0}};
  scene.shadows = false;
  RackImageRenderer renderer(scene, geometry::Camera(), perfect_image_sensor());
  const auto spread_along = [&](double y) {
    const rack_vision::Pipe& pipe = scene.model.pipes[2];
    const geometry::SE3 pose = test::looking(true, {pipe.start.x(), y, 2.5});
    const GreyImage image = test::render(renderer, {.T_camera_rack = pose, .light = even_light()});
    double low = 255;
    double high = 0;
    for (int v = 0; v < image.height; ++v) {
      low = std::min(low, image.at(360, v));
      high = std::max(high, image.at(360, v));
    }
    return high - low;
  };
  EXPECT_LE(spread_along(4.0), 1);
  EXPECT_GT(spread_along(7.0), 20);
}

TEST(RackImageTexture, DrawsDarkAndBrightPipes) {
  // Over some seeds, finishes differ so much that edges of both signs appear.
  int brighter = 0;
  int darker = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    RackScene scene{.model = test::paper_rack()};
    scene.seed = seed;
    RackImageRenderer renderer(scene, geometry::Camera(), perfect_image_sensor());
    const geometry::SE3 pose = test::looking(true, {0.8, 4.5, 3});
    const GreyImage image = test::render(renderer, {.T_camera_rack = pose});
    for (const rack_vision::Pipe& pipe : scene.model.pipes) {
      const double radius = pipe.radii[0].radius;
      const auto mean = [&](double x, double z) {
        double sum = 0;
        for (int i = 0; i < 50; ++i) {
          sum += bilinear(
              image, *geometry::Camera().project(pose * Eigen::Vector3d(x, 3.9 + 0.02 * i, z)));
        }
        return sum / 50;
      };
      const double on = mean(pipe.start.x(), pipe.start.z() + radius);
      const double beside = mean(pipe.start.x() - radius - 0.05, pipe.start.z());
      brighter += on > beside + 15 ? 1 : 0;
      darker += on < beside - 15 ? 1 : 0;
    }
  }
  EXPECT_GE(brighter, 4);
  EXPECT_GE(darker, 4);
}

TEST(RackImageClutter, HidesTheStatedShareOfTheContours) {
  RackScene scene{.model = test::paper_rack()};
  std::vector<geometry::SE3> views;
  for (const double y : {2.5, 5.0, 7.5}) {
    views.push_back(test::looking(true, {0.8, y, 3}));
  }
  double sum = 0;
  constexpr std::uint64_t kScenes = 4;
  for (scene.seed = 1; scene.seed <= kScenes; ++scene.seed) {
    scene.clutter_share = 0;
    EXPECT_EQ(cluttered_contour_share(scene, geometry::Camera(), views), 0);
    scene.clutter_share = 0.4;
    sum += cluttered_contour_share(scene, geometry::Camera(), views);
  }
  EXPECT_NEAR(sum / kScenes, 0.4, 0.06);
  EXPECT_EQ(cluttered_contour_share(scene, geometry::Camera(), {}), 0) << "no view";
}

TEST(RackImageRendererMemory, IsTakenAtConstructionOnly) {
  RackScene scene{.model = test::paper_rack()};
  scene.clutter_share = 0.4;
  RackImageRenderer renderer(scene, geometry::Camera());
  std::vector<std::uint8_t> grey(720 * 480);
  RackView view{.T_camera_rack = test::looking(true, {0.8, 4, 3})};
  view.velocity << 0.5, 0.5, 0, 0.2, 0.2, 0.2;
  const pipescout::test::HeapGuard guard;
  renderer.render(view, grey);
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
}  // namespace pipescout::simulation
