// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "rack_image_scenes.hpp"

/// Where silhouettes lie, against the tangent planes of cylinders and cones in closed form. The
/// camera looks up, so that the background is the even sky; pipes without texture are black before
/// a bright sky, or lit from the side before a black one.
namespace pipescout::simulation {
namespace {

using test::GreyImage;

/// Points of a silhouette in the (distorted) image, from start to end of the pipe.
struct Silhouette {
  std::vector<Eigen::Vector2d> pixels;
  Eigen::Vector3d normal;  // of the surface
};

Silhouette silhouette(const rack_vision::Pipe& pipe, double sign, const geometry::Camera& camera,
                      const geometry::SE3& T_camera_rack) {
  const double length = pipe.length();
  const double slope = (pipe.radii.back().radius - pipe.radii.front().radius) / length;
  const Eigen::Vector3d from_start = T_camera_rack.inverse().translation() - pipe.start;
  const double along = from_start.dot(pipe.direction);
  const Eigen::Vector3d beside = from_start - along * pipe.direction;
  // Radial directions e with e . (eye - start) = radius at the eye's place.
  const double radius = pipe.radii.front().radius + slope * along;
  const double cosine = radius / beside.norm();
  const Eigen::Vector3d towards = beside.normalized();
  const Eigen::Vector3d e =
      cosine * towards + sign * std::sqrt(1 - cosine * cosine) * pipe.direction.cross(towards);
  Silhouette result{.pixels = {}, .normal = (e - slope * pipe.direction).normalized()};
  for (double s = 0; s <= length; s += 0.002) {
    const Eigen::Vector3d point =
        pipe.start + s * pipe.direction + (pipe.radii.front().radius + slope * s) * e;
    const std::optional<Eigen::Vector2d> pixel = camera.project(T_camera_rack * point);
    if (pixel) {
      result.pixels.push_back(*pixel);
    }
  }
  return result;
}

struct EdgeError {
  double mean = 0;
  double rms = 0;
  int rows = 0;
};

/// Measured minus true place of the silhouette across rows (columns when it runs along them), by
/// the area under the profile: exact for any blur that is even. `reach`: pixels to either side.
EdgeError edge_error(const GreyImage& image, const Silhouette& edge, double background, int reach) {
  const Eigen::Vector2d direction = edge.pixels.back() - edge.pixels.front();
  const bool by_rows = std::abs(direction.y()) > std::abs(direction.x());
  const int across = by_rows ? 0 : 1;
  const int width = by_rows ? image.width : image.height;
  const int height = by_rows ? image.height : image.width;
  EdgeError error;
  double sum = 0;
  double squares = 0;
  for (std::size_t i = 1; i < edge.pixels.size(); ++i) {
    Eigen::Vector2d a = edge.pixels[i - 1];
    Eigen::Vector2d b = edge.pixels[i];
    if (a[1 - across] > b[1 - across]) {
      std::swap(a, b);
    }
    const int row = static_cast<int>(std::ceil(a[1 - across]));
    if (row >= b[1 - across] || row < 8 || row >= height - 8) {
      continue;
    }
    const double t = (row - a[1 - across]) / (b[1 - across] - a[1 - across]);
    const double truth = a[across] + t * (b[across] - a[across]);
    const int middle = static_cast<int>(std::lround(truth));
    if (middle < reach + 4 || middle + reach + 4 >= width) {
      continue;
    }
    const auto level = [&](int place) {
      return by_rows ? image.at(place, row) : image.at(row, place);
    };
    const bool pipe_above =
        std::abs(level(middle + reach) - background) > std::abs(level(middle - reach) - background);
    // Near a silhouette Lambert's law is linear in the distance from it.
    const int inside = pipe_above ? middle + reach : middle - reach;
    const double slope =
        (level(inside + (pipe_above ? 2 : -2)) - level(inside)) / (pipe_above ? 2 : -2);
    double area = 0;
    for (int place = middle - reach; place <= middle + reach; ++place) {
      const double body = level(inside) + slope * (place - inside);
      area += (level(place) - body) / (background - body);
    }
    const double measured = pipe_above ? middle - reach - 0.5 + area : middle + reach + 0.5 - area;
    sum += measured - truth;
    squares += (measured - truth) * (measured - truth);
    ++error.rows;
  }
  error.mean = sum / error.rows;
  error.rms = std::sqrt(squares / error.rows);
  return error;
}

geometry::CameraParameters distorted() {
  geometry::CameraParameters parameters;
  parameters.k1 = -0.2;
  parameters.k2 = 0.08;
  parameters.p1 = 0.001;
  parameters.p2 = -0.0015;
  return parameters;
}

class RackImageSilhouette : public testing::TestWithParam<int> {
 protected:
  /// Each case is another alignment, from parallel to the pixel columns to parallel to the rows.
  [[nodiscard]] geometry::SE3 pose() const {
    const double turn = 0.31 * GetParam();
    const Eigen::Vector3d tilt(0.05 * GetParam(), -0.08, turn);
    return test::looking(false, {0.013 * GetParam(), 4.9, -2.1},
                         GetParam() == 0 ? Eigen::Vector3d::Zero() : tilt);
  }
  [[nodiscard]] static RackScene scene(double albedo) {
    RackScene scene;
    scene.model.pipes = {test::pipe("cylinder", {-0.35, 0, 0.2}, {0, 1, 0}, {{0, 0.2}, {10, 0.2}}),
                         test::pipe("cone", {0.4, 0, 0.25}, {0, 1, 0}, {{0, 0.12}, {10, 0.24}})};
    scene.finishes.assign(2, {.albedo = albedo, .rust = 0, .contrast = 0, .gloss = 0});
    return scene;
  }
};

TEST_P(RackImageSilhouette, OfADarkPipeIsWhereTheTangentPlanesAre) {
  for (const geometry::CameraParameters& parameters : {geometry::CameraParameters{}, distorted()}) {
    const geometry::Camera camera(parameters);
    const RackScene dark = scene(0.02);
    RackImageRenderer renderer(dark, camera, perfect_image_sensor());
    const RackLight light{.sun = 0, .sky = 0.9, .gain = 1.1, .offset = 5};
    const GreyImage image = test::render(renderer, {.T_camera_rack = pose(), .light = light});
    const double background = 255 * 1.1 * 0.9 * 0.9 + 5;
    for (const rack_vision::Pipe& pipe : dark.model.pipes) {
      for (const double sign : {-1.0, 1.0}) {
        const EdgeError error =
            edge_error(image, silhouette(pipe, sign, camera, pose()), background, 3);
        ASSERT_GT(error.rows, 200);
        EXPECT_LT(std::abs(error.mean), 0.02) << pipe.name << " " << sign;
        EXPECT_LT(error.rms, 0.03) << pipe.name << " " << sign;
      }
    }
  }
}

TEST_P(RackImageSilhouette, OfABrightPipeIsWhereTheTangentPlanesAre) {
  const geometry::Camera camera;
  RackScene bright = scene(0.95);
  bright.shadows = false;
  RackImageRenderer renderer(bright, camera, perfect_image_sensor());
  for (const rack_vision::Pipe& pipe : bright.model.pipes) {
    for (const double sign : {-1.0, 1.0}) {
      const Silhouette edge = silhouette(pipe, sign, camera, pose());
      // Light along the normal of the silhouette: there the shading is flat.
      const RackLight light{.to_sun = edge.normal, .sun = 0.9, .sky = 0, .gain = 1, .offset = 5};
      const GreyImage image = test::render(renderer, {.T_camera_rack = pose(), .light = light});
      const EdgeError error = edge_error(image, edge, 5, 2);
      ASSERT_GT(error.rows, 200);
      EXPECT_LT(std::abs(error.mean), 0.02) << pipe.name << " " << sign;
      EXPECT_LT(error.rms, 0.03) << pipe.name << " " << sign;
    }
  }
}

TEST_P(RackImageSilhouette, IsNotMovedByBlur) {
  const geometry::Camera camera;
  const RackScene dark = scene(0.02);
  ImageSensor sensor = perfect_image_sensor();
  sensor.lens_blur = 0.9;
  sensor.exposure = 0.004;
  RackImageRenderer renderer(dark, camera, sensor);
  RackView view{.T_camera_rack = pose(), .light = {.sun = 0, .sky = 0.9, .gain = 1.1, .offset = 5}};
  view.velocity << 0.5, -0.4, 0.2, 0.4, 0.8, 0.5;  // some 3 pixels
  const GreyImage image = test::render(renderer, view);
  const double background = 255 * 1.1 * 0.9 * 0.9 + 5;
  for (const rack_vision::Pipe& pipe : dark.model.pipes) {
    for (const double sign : {-1.0, 1.0}) {
      const EdgeError error =
          edge_error(image, silhouette(pipe, sign, camera, pose()), background, 7);
      ASSERT_GT(error.rows, 200);
      EXPECT_LT(std::abs(error.mean), 0.02) << pipe.name << " " << sign;
      EXPECT_LT(error.rms, 0.04) << pipe.name << " " << sign;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Alignments, RackImageSilhouette, testing::Values(0, 1, 2, 3, 4, 5));

}  // namespace
}  // namespace pipescout::simulation
