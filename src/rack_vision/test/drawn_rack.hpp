// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/surface_points.hpp"

/// Images of a rack by the simplest of ray casters: pipes with a procedural texture over a plain
/// ground, 2 x 2 rays a pixel, no noise.
namespace pipescout::rack_vision::test {

struct DrawnImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;
  [[nodiscard]] ImageView view() const { return {pixels.data(), width, height, width}; }
};

inline RackModel drawn_rack() {
  const std::vector<RowPipe> row{{"a", {{0, 0.15}, {10, 0.15}}, 0},
                                 {"b", {{0, 0.20}, {10, 0.20}}, 0.1},
                                 {"c", {{0, 0.15}, {10, 0.15}}, 0.1},
                                 {"d", {{0, 0.18}, {10, 0.18}}, 0.1}};
  RackModel model;
  model.pipes = row_of_pipes(row);
  return model;
}

/// With a beam across it, whose ends a camera above its middle sees.
inline RackModel rack_on_a_beam() {
  RackModel model = drawn_rack();
  model.supports.push_back({"beam", {-0.2, 3.9, -0.2}, {1.9, 4.1, 0}});
  return model;
}

inline geometry::Camera drawn_camera() {
  geometry::CameraParameters parameters;
  parameters.width = 360;
  parameters.height = 240;
  parameters.focal_length = 315;
  parameters.centre_u = 180;
  parameters.centre_v = 120;
  return geometry::Camera(parameters);
}

/// Looking down from `height` m above the middle of the rack.
inline geometry::SE3 drawn_pose(double x, double y, double height, double yaw) {
  return {geometry::SO3::about_z(yaw) * geometry::SO3::about_x(std::numbers::pi), {x, y, height}};
}

inline double drawn_texture(double along, double angle) {
  double sum = 0;
  for (int k = 1; k <= 4; ++k) {
    sum += std::sin(23.0 * k * along + 3.1 * k * angle + 1.7 * k * k) *
           std::cos(9.0 * k * angle - 11.0 * k * along + 0.6 * k);
  }
  return sum / 4;
}

/// `T_rack_camera_of`: a function of the row; `contrast`: of the texture; 0: plain paint.
template <typename PoseOfRow>
DrawnImage draw_rows(const RackModel& model, const geometry::Camera& camera,
                     const PoseOfRow& T_rack_camera_of, double gain, double contrast) {
  const RackSurface surface(model, {});
  const int width = camera.parameters().width;
  const int height = camera.parameters().height;
  DrawnImage image{width, height, {}};
  image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  constexpr int kRays = 2;
  for (int v = 0; v < height; ++v) {
    const geometry::SE3 T_rack_camera = T_rack_camera_of(v);
    for (int u = 0; u < width; ++u) {
      double sum = 0;
      for (int ray = 0; ray < kRays * kRays; ++ray) {
        const Eigen::Vector2d at(u + (ray % kRays - 0.5) / kRays, v + (ray / kRays - 0.5) / kRays);
        const Eigen::Vector3d direction =
            T_rack_camera.rotation() * (camera.inverse_matrix() * at.homogeneous());
        const auto hit = surface.first_hit(T_rack_camera.translation(), direction);
        if (!hit) {
          sum += 70;
          continue;
        }
        const double angle = std::atan2(hit->normal.x(), hit->normal.z());
        sum += 130 + 60 * contrast * drawn_texture(hit->point.y() + 3.0 * hit->body, angle);
      }
      const double grey = gain * sum / (kRays * kRays);
      image.pixels[static_cast<std::size_t>(v * width + u)] =
          static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
    }
  }
  return image;
}

inline DrawnImage draw(const RackModel& model, const geometry::Camera& camera,
                       const geometry::SE3& T_rack_camera, double gain = 1.0,
                       double contrast = 1.0) {
  return draw_rows(
      model, camera, [&](int) { return T_rack_camera; }, gain, contrast);
}

/// By a rolling shutter: rows from the top, `row_time` s after each other. `T_rack_camera`: of the
/// middle of the image; `velocity`: m/s along the rack's axes, rad/s about them.
inline DrawnImage draw_rolling(const RackModel& model, const geometry::Camera& camera,
                               const geometry::SE3& T_rack_camera,
                               const geometry::Vector6d& velocity, double row_time) {
  const double middle_row = 0.5 * (camera.parameters().height - 1);
  const auto at_row = [&](int v) {
    const geometry::Vector6d moved = row_time * (v - middle_row) * velocity;
    return geometry::SE3(geometry::SO3::exp(moved.tail<3>()) * T_rack_camera.rotation(),
                         T_rack_camera.translation() + moved.head<3>());
  };
  return draw_rows(model, camera, at_row, 1.0, 1.0);
}

/// With white noise, one sigma in grey levels.
inline DrawnImage noisy(DrawnImage image, double sigma, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal(0.0, std::max(sigma, 1e-9));
  for (std::uint8_t& pixel : image.pixels) {
    pixel = static_cast<std::uint8_t>(std::clamp(std::lround(pixel + normal(engine)), 0L, 255L));
  }
  return image;
}

}  // namespace pipescout::rack_vision::test
