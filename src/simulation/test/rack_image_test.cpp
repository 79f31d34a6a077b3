// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_image.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "rack_image_scenes.hpp"

namespace pipescout::simulation {
namespace {

using test::GreyImage;

/// A camera that looks up past a rack: nothing but sky of one radiance.
RackView of_the_sky() {
  return {.T_camera_rack = test::looking(false, {50, 0, 0}),
          .light = {.sun = 0, .sky = 0.5, .gain = 1, .offset = 10}};
}
constexpr double kSkyLevel = 255 * 0.9 * 0.5;  // without the offset

/// One pipe about x = 0, and another where no test looks: a rack has two.
RackScene plain_scene(double albedo) {
  RackScene scene;
  scene.model.pipes = {test::pipe("a", {0, 0, 0.2}, {0, 1, 0}, {{0, 0.2}, {10, 0.2}}),
                       test::pipe("far", {30, 0, 0.2}, {0, 1, 0}, {{0, 0.2}, {10, 0.2}})};
  scene.finishes.assign(2, {.albedo = albedo, .rust = 0, .contrast = 0, .gloss = 0});
  scene.shadows = false;
  return scene;
}

struct Moments {
  double mean = 0;
  double variance = 0;
};

Moments moments(const GreyImage& image) {
  double sum = 0;
  double squares = 0;
  for (const std::uint8_t pixel : image.pixels) {
    sum += pixel;
    squares += static_cast<double>(pixel) * pixel;
  }
  const auto n = static_cast<double>(image.pixels.size());
  return {sum / n, squares / n - sum / n * (sum / n)};
}

TEST(RackImage, ShadesByLambertsLaw) {
  const geometry::Camera camera;
  RackImageRenderer renderer(plain_scene(0.8), camera, perfect_image_sensor());
  const Eigen::Vector3d eye(0.1, 5, 2.5);
  const RackView view{.T_camera_rack = test::looking(true, eye),
                      .light = {.to_sun = Eigen::Vector3d(0.5, 0.2, 0.8).normalized(),
                                .sun = 0.9,
                                .sky = 0,
                                .gain = 1,
                                .offset = 3}};
  const GreyImage image = test::render(renderer, view);
  int pixels = 0;
  for (int u = 0; u < image.width; ++u) {
    const Eigen::Vector3d ray =
        view.T_camera_rack.inverse().rotation() * *camera.ray(Eigen::Vector2d(u, 200));
    // The circle x^2 + (z - 0.2)^2 = 0.2^2 in the plane across the pipe.
    const Eigen::Vector2d d(ray.x(), ray.z());
    const Eigen::Vector2d o(eye.x(), eye.z() - 0.2);
    const double b = o.dot(d);
    const double discriminant = b * b - d.squaredNorm() * (o.squaredNorm() - 0.04);
    if (discriminant > 0.002) {
      const double t = (-b - std::sqrt(discriminant)) / d.squaredNorm();
      const Eigen::Vector2d n = (o + t * d) / 0.2;
      const double cosine =
          std::max(0.0, n.x() * view.light.to_sun.x() + n.y() * view.light.to_sun.z());
      EXPECT_NEAR(image.at(u, 200), 3 + 255 * 0.8 * 0.9 * cosine, 0.51) << u;
      ++pixels;
    }
  }
  EXPECT_GT(pixels, 80);
}

TEST(RackImage, GainMultipliesAndOffsetAdds) {
  RackScene scene{.model = test::paper_rack()};
  RackImageRenderer renderer(scene, geometry::Camera(), perfect_image_sensor());
  RackView view{.T_camera_rack = test::looking(true, {0.8, 4, 3}),
                .light = {.gain = 0.5, .offset = 0}};
  const GreyImage once = test::render(renderer, view);
  view.light.gain = 1;
  view.light.offset = 20;
  const GreyImage twice = test::render(renderer, view);
  for (std::size_t i = 0; i < once.pixels.size(); ++i) {
    if (twice.pixels[i] < 255) {
      ASSERT_NEAR(twice.pixels[i] - 20.0, 2.0 * once.pixels[i], 1.51);
    }
  }
}

TEST(RackImage, NoiseHasTheStatedVariance) {
  ImageSensor sensor = perfect_image_sensor();
  sensor.electrons_per_level = 20;
  sensor.read_noise = 1.5;
  RackImageRenderer renderer(plain_scene(0.5), geometry::Camera(), sensor);
  const Moments found = moments(test::render(renderer, of_the_sky()));
  const double variance = 1.5 * 1.5 + kSkyLevel / 20 + 1.0 / 12;  // the last: quantisation
  const double n = 720 * 480;
  EXPECT_NEAR(found.mean, kSkyLevel + 10, 4 * std::sqrt(variance / n));
  EXPECT_NEAR(found.variance, variance, 5 * variance * std::sqrt(2 / n));
}

TEST(RackImage, LosesLightTowardsTheCorners) {
  ImageSensor sensor = perfect_image_sensor();
  sensor.vignetting = 0.4;
  RackImageRenderer renderer(plain_scene(0.5), geometry::Camera(), sensor);
  const GreyImage image = test::render(renderer, of_the_sky());
  EXPECT_NEAR(image.at(360, 240), kSkyLevel + 10, 0.51);
  EXPECT_NEAR(image.at(0, 0), 0.6 * kSkyLevel + 10, 0.51);
  const double half = (0.25 * 360 * 360) / (360.0 * 360 + 240 * 240);
  EXPECT_NEAR(image.at(180, 240), (1 - 0.4 * half) * kSkyLevel + 10, 0.51);
}

/// Variance of the line spread of the left silhouette of a black pipe against the sky, pixels^2,
/// within `reach` pixels.
double line_spread(const ImageSensor& sensor, const geometry::Vector6d& velocity, int reach) {
  // Noise, or the rounding of the faint shading inside would not average out.
  ImageSensor noisy = sensor;
  noisy.read_noise = 0.5;
  RackImageRenderer renderer(plain_scene(0.02), geometry::Camera(), noisy);
  // Turned a little, so that the silhouette passes all places within a pixel.
  RackView view{.T_camera_rack = test::looking(false, {-0.2, 5, -2}, {0, 0, 0.05}),
                .velocity = velocity,
                .light = {.sun = 0, .sky = 1, .gain = 1, .offset = 2}};
  const GreyImage image = test::render(renderer, view);
  double sum = 0;
  int rows = 0;
  for (int v = 40; v < image.height - 40; ++v) {
    int edge = 1;
    while (image.at(edge, v) > 120) {
      ++edge;
    }
    double weight = 0;
    double first = 0;
    double second = 0;
    for (int u = edge - reach - 1; u < edge + reach; ++u) {
      const double step = image.at(u, v) - image.at(u + 1, v);
      weight += step;
      first += step * (u - edge);
      second += step * (u - edge) * (u - edge);
    }
    sum += second / weight - first * first / (weight * weight);
    ++rows;
  }
  return sum / rows;
}

/// What a perfect sensor shows of the same silhouette, pixels and shading, is not blur.
double blur_variance(const ImageSensor& sensor, const geometry::Vector6d& velocity, int reach) {
  return line_spread(sensor, velocity, reach) -
         line_spread(perfect_image_sensor(), geometry::Vector6d::Zero(), reach);
}

TEST(RackImage, LensBlurHasTheStatedWidth) {
  for (const double sigma : {0.7, 1.0, 1.8}) {
    ImageSensor sensor = perfect_image_sensor();
    sensor.lens_blur = sigma;
    const int reach = static_cast<int>(std::ceil(4 * sigma)) + 1;
    EXPECT_NEAR(blur_variance(sensor, geometry::Vector6d::Zero(), reach), sigma * sigma,
                0.05 + 0.02 * sigma * sigma);
  }
}

TEST(RackImage, MotionBlurIsAsLongAsThePath) {
  ImageSensor sensor = perfect_image_sensor();
  sensor.exposure = 0.02;
  geometry::Vector6d velocity = geometry::Vector6d::Zero();
  for (const double speed : {0.3, 0.6, 1.0}) {
    velocity.x() = speed;
    const double path = speed * 0.02 * 630 / 2.2;  // the axis is 2.2 m away
    const int reach = static_cast<int>(std::ceil(path / 2)) + 3;
    EXPECT_NEAR(blur_variance(sensor, velocity, reach), path * path / 12,
                0.05 + 0.02 * path * path / 12);
  }
  // Along the silhouette nothing is blurred but by the slant of 0.05.
  velocity << 0, 1, 0, 0, 0, 0;
  EXPECT_LT(blur_variance(sensor, velocity, 6), 0.1);
}

/// From the left, pixels, where the row first shows the black pipe.
double first_silhouette(const GreyImage& image, int v) {
  constexpr double kHalf = 128;
  int u = 1;
  while (image.at(u, v) > kHalf) {
    ++u;
  }
  return u - (kHalf - image.at(u, v)) / (image.at(u - 1, v) - image.at(u, v));
}

TEST(RackImage, ARollingShutterShowsEachRowFromWhereTheCameraIsThen) {
  const RackView view{.T_camera_rack = test::looking(false, {-0.2, 5, -2}),
                      .velocity = 0.5 * geometry::Vector6d::UnitX(),
                      .light = {.sun = 0, .sky = 1, .gain = 1, .offset = 2}};
  ImageSensor sensor = perfect_image_sensor();
  RackImageRenderer at_once(plain_scene(0.02), geometry::Camera(), sensor);
  sensor.row_time = 1e-4;
  RackImageRenderer row_by_row(plain_scene(0.02), geometry::Camera(), sensor);
  const GreyImage still = test::render(at_once, view);
  const GreyImage skewed = test::render(row_by_row, view);
  for (const int v : {40, 239, 439}) {
    const double moved = 0.5 * sensor.row_time * (v - 239.5) * 630 / 2.2;  // the axis is 2.2 m away
    EXPECT_NEAR(first_silhouette(skewed, v) - first_silhouette(still, v), -moved, 0.2) << v;
  }
}

TEST(RackImage, NearBodiesHideFarOnes) {
  RackScene scene;
  scene.model.pipes = {test::pipe("upper", {0, 0, 0.6}, {0, 1, 0}, {{0, 0.2}, {10, 0.2}}),
                       test::pipe("lower", {-3, 5, 0.2}, {1, 0, 0}, {{0, 0.15}, {6, 0.15}})};
  scene.model.supports = {{"beam", {-3, 4.8, -0.3}, {3, 5.2, 0}}};
  scene.finishes = {{.albedo = 0.9, .rust = 0, .contrast = 0, .gloss = 0},
                    {.albedo = 0.05, .rust = 0, .contrast = 0, .gloss = 0}};
  scene.shadows = false;
  RackImageRenderer renderer(scene, geometry::Camera(), perfect_image_sensor());
  const geometry::SE3 pose = test::looking(true, {0, 5, 3});
  const GreyImage image = test::render(
      renderer, {.T_camera_rack = pose,
                 .light = {.to_sun = {0, 0, 1}, .sun = 1, .sky = 0, .gain = 1, .offset = 0}});
  const auto level_at = [&](const Eigen::Vector3d& point) {
    const Eigen::Vector2d pixel = *geometry::Camera().project(pose * point);
    return image.at(static_cast<int>(std::lround(pixel.x())),
                    static_cast<int>(std::lround(pixel.y())));
  };
  EXPECT_NEAR(level_at({0, 5, 0.8}), 255 * 0.9, 1);       // the crossing
  EXPECT_NEAR(level_at({0.8, 5, 0.35}), 255 * 0.05, 1);   // the lower pipe beside it
  EXPECT_NEAR(level_at({-0.8, 5, 0.35}), 255 * 0.05, 1);  // and on the other side
  const double beam = level_at({0.8, 5.18, 0});
  EXPECT_GT(beam, 255 * 0.1);
  EXPECT_LT(beam, 255 * 0.6);
}

TEST(RackImage, PipesCastShadows) {
  RackScene scene = plain_scene(0.5);
  scene.model.pipes[1].start.x() = 0.7;
  const geometry::SE3 pose = test::looking(true, {0.7, 5, 3});
  // A low sun on the right: b's shadow falls on the right flank of a.
  const RackLight light{.to_sun = Eigen::Vector3d(1, 0, 0.05).normalized(), .sun = 1, .sky = 0};
  RackImageRenderer without(scene, geometry::Camera(), perfect_image_sensor());
  scene.shadows = true;
  RackImageRenderer with(scene, geometry::Camera(), perfect_image_sensor());
  // A line to the sun touches b's circle; where it meets a's is the border of the shadow.
  const auto border_distance = [&](double angle) {
    const Eigen::Vector2d point(0.2 * std::sin(angle), 0.2 + 0.2 * std::cos(angle));
    const Eigen::Vector2d sun(light.to_sun.x(), light.to_sun.z());
    const Eigen::Vector2d to_axis = Eigen::Vector2d(0.7, 0.2) - point;
    return std::abs(to_axis.x() * sun.y() - to_axis.y() * sun.x()) - 0.2;
  };
  const GreyImage shaded = test::render(with, {.T_camera_rack = pose, .light = light});
  const GreyImage open = test::render(without, {.T_camera_rack = pose, .light = light});
  int dark = 0;
  int lit = 0;
  for (double angle = 0.1; angle < 1.2; angle += 0.005) {
    const Eigen::Vector3d point(0.2 * std::sin(angle), 5, 0.2 + 0.2 * std::cos(angle));
    const Eigen::Vector2d pixel = *geometry::Camera().project(pose * point);
    const int u = static_cast<int>(std::lround(pixel.x()));
    const int v = static_cast<int>(std::lround(pixel.y()));
    if (border_distance(angle) < -0.02) {
      EXPECT_NEAR(shaded.at(u, v), light.offset, 0.51) << angle;
      ++dark;
    } else if (border_distance(angle) > 0.02) {
      EXPECT_EQ(shaded.at(u, v), open.at(u, v)) << angle;
      ++lit;
    }
  }
  EXPECT_GT(dark, 20);
  EXPECT_GT(lit, 5);
}

/// Column and row in which the rack's point is seen.
std::pair<int, int> pixel_of(const geometry::Camera& camera, const RackView& view,
                             const Eigen::Vector3d& point) {
  const auto seen = camera.project(view.T_camera_rack * point);
  return {static_cast<int>(std::lround(seen->x())), static_cast<int>(std::lround(seen->y()))};
}

TEST(RackImage, ShowsBodiesThatTheModelDoesNotHave) {
  const geometry::Camera camera;
  RackScene scene = plain_scene(0.1);
  const RackView view{.T_camera_rack = test::looking(true, {0, 5, 2.5}),
                      .light = {.sun = 0, .sky = 0.5, .gain = 1, .offset = 0}};
  RackImageRenderer bare(scene, camera, perfect_image_sensor());
  scene.bodies.cylinders = {{.start = {0, 4.95, 0.2},
                             .direction = {0, 1, 0},
                             .length = 0.1,
                             .radius = 0.25,
                             .albedo = 0.9}};
  scene.bodies.boxes = {
      {.lowest_corner = {0.5, 4.9, 0}, .highest_corner = {0.7, 5.1, 0.1}, .albedo = 0.9}};
  RackImageRenderer fitted(scene, camera, perfect_image_sensor());
  const GreyImage before = test::render(bare, view);
  const GreyImage after = test::render(fitted, view);
  for (const Eigen::Vector3d& on_body :
       {Eigen::Vector3d(0, 5, 0.45), Eigen::Vector3d(0.22, 5, 0.3), Eigen::Vector3d(0.6, 5, 0.1)}) {
    const auto [u, v] = pixel_of(camera, view, on_body);
    EXPECT_GT(after.at(u, v), before.at(u, v) + 20);
  }
  const auto [u, v] = pixel_of(camera, view, {0, 5.2, 0.4});
  EXPECT_EQ(after.at(u, v), before.at(u, v));
}

TEST(RackImage, PeopleStandAndCastShadowsWhereTheViewHasThem) {
  const geometry::Camera camera;
  RackScene scene = plain_scene(0.8);
  scene.shadows = true;
  scene.people = 1;
  RackImageRenderer renderer(scene, camera, perfect_image_sensor());
  RackView view{.T_camera_rack = test::looking(true, {0, 5, 3}),
                .light = {.to_sun = Eigen::Vector3d(1, 0, 1).normalized(),
                          .sun = 0.9,
                          .sky = 0.2,
                          .gain = 1,
                          .offset = 0}};
  const std::vector<Eigen::Vector3d> near{{0.9, 5, -0.3}};
  const std::vector<Eigen::Vector3d> away{{0.9, 6, -0.3}};
  const auto [u, v] = pixel_of(camera, view, {0.1, 5, 0.2 + std::sqrt(0.2 * 0.2 - 0.1 * 0.1)});
  const auto [u_away, v_away] =
      pixel_of(camera, view, {0.1, 6, 0.2 + std::sqrt(0.2 * 0.2 - 0.1 * 0.1)});
  view.people = near;
  const GreyImage first = test::render(renderer, view);
  view.people = away;
  const GreyImage second = test::render(renderer, view);
  EXPECT_LT(first.at(u, v), 0.5 * second.at(u, v));
  EXPECT_LT(second.at(u_away, v_away), 0.5 * first.at(u_away, v_away));
  view.people = {};
  EXPECT_THROW(test::render(renderer, view), std::invalid_argument);
}

TEST(RackImage, IsTheSameForTheSameSeedAndFrame) {
  RackScene scene{.model = test::paper_rack()};
  scene.clutter_share = 0.3;
  RackImageRenderer one(scene, geometry::Camera());
  RackImageRenderer other(scene, geometry::Camera());
  RackView view{.T_camera_rack = test::looking(true, {0.8, 4, 3}, {0.02, 0.1, 0.3})};
  view.velocity << 0.3, 0.2, 0, 0.1, 0.1, 0.4;
  view.frame = 7;
  const GreyImage first = test::render(one, view);
  view.frame = 8;
  EXPECT_NE(test::render(one, view).pixels, first.pixels);
  view.frame = 7;
  EXPECT_EQ(test::render(one, view).pixels, first.pixels);
  EXPECT_EQ(test::render(other, view).pixels, first.pixels);
  scene.seed = 2;
  RackImageRenderer another(scene, geometry::Camera());
  EXPECT_NE(test::render(another, view).pixels, first.pixels);
}

TEST(RackImage, RefusesBadInput) {
  const auto fails_with = [](const auto& act, const std::string& text) {
    try {
      act();
      FAIL() << "no exception for " << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  };
  const RackScene good = plain_scene(0.5);
  const geometry::Camera camera;
  RackScene scene = good;
  scene.model.pipes.clear();
  fails_with([&] { RackImageRenderer(scene, camera); }, "pipes");
  scene = good;
  scene.finishes.resize(3);
  fails_with([&] { RackImageRenderer(scene, camera); }, "RackScene.finishes: 3");
  scene = good;
  scene.finishes[0].rust = 1.5;
  fails_with([&] { RackImageRenderer(scene, camera); }, "RackScene.finishes[0].rust: 1.5");
  scene = good;
  scene.clutter_share = std::numeric_limits<double>::quiet_NaN();
  fails_with([&] { RackImageRenderer(scene, camera); }, "RackScene.clutter_share");
  ImageSensor sensor;
  sensor.lens_blur = -1;
  fails_with([&] { RackImageRenderer(good, camera, sensor); }, "ImageSensor.lens_blur: -1");
  sensor = {.row_time = 1};
  fails_with([&] { RackImageRenderer(good, camera, sensor); }, "ImageSensor.row_time: 1");

  RackImageRenderer renderer(good, camera);
  std::vector<std::uint8_t> grey(720 * 480);
  fails_with([&] { renderer.render({}, std::span(grey).first(100)); }, "100 pixels");
  RackView view;
  view.light.to_sun *= 2;
  fails_with([&] { renderer.render(view, grey); }, "RackLight.to_sun");
  view = {};
  view.velocity[3] = std::numeric_limits<double>::infinity();
  fails_with([&] { renderer.render(view, grey); }, "RackView.velocity");
}

TEST(RackImage, RefusesBodiesThatAreNone) {
  const auto refuses = [](const SceneBodies& bodies) {
    RackScene scene = plain_scene(0.5);
    scene.bodies = bodies;
    EXPECT_THROW(scene.validate(), std::invalid_argument);
  };
  refuses({.cylinders = {{.length = 1, .radius = 0}}});
  refuses({.cylinders = {{.direction = {0, 0, 2}, .length = 1, .radius = 0.1}}});
  refuses({.cylinders = {{.length = 1, .radius = std::numeric_limits<double>::quiet_NaN()}}});
  refuses({.boxes = {{.lowest_corner = {0, 0, 0}, .highest_corner = {1, 1, 0}}}});
  RackScene crowd = plain_scene(0.5);
  crowd.people = kMostPeople + 1;
  EXPECT_THROW(crowd.validate(), std::invalid_argument);
}

TEST(RackImage, HasPlaceForAnyView) {
  // Inside a pipe, level with the ground, below it, straight along the pipes, up side down.
  RackScene scene{.model = test::paper_rack()};
  scene.clutter_share = 0.5;
  geometry::CameraParameters small;
  small.width = 37;
  small.height = 21;
  small.centre_u = 18;
  small.centre_v = 10;
  small.focal_length = 30;
  RackImageRenderer renderer(scene, geometry::Camera(small));
  for (const geometry::SE3& pose :
       {test::looking(true, {0.55, 5, 0.2}), test::looking(true, {0, 0, -4}),
        test::looking(false, {0, 0, -9}), test::looking(true, {0.55, -3, 0.2}, {-1.5707963, 0, 0}),
        test::looking(true, {0.5, 5, 3}, {3, 0.2, 0}), test::looking(true, {0, 0, 400})}) {
    EXPECT_EQ(test::render(renderer, {.T_camera_rack = pose}).pixels.size(), 37U * 21U);
  }
}

}  // namespace
}  // namespace pipescout::simulation
