// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "pipescout/simulation/rack_image.hpp"

/// Racks, poses and images for the tests of the image renderer.
namespace pipescout::simulation::test {

struct GreyImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;

  [[nodiscard]] double at(int u, int v) const {
    return pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(u)];
  }
};

inline GreyImage render(RackImageRenderer& renderer, const RackView& view) {
  GreyImage image;
  image.width = renderer.camera().parameters().width;
  image.height = renderer.camera().parameters().height;
  image.pixels.resize(static_cast<std::size_t>(image.width) *
                      static_cast<std::size_t>(image.height));
  renderer.render(view, image.pixels);
  return image;
}

inline rack_vision::Pipe pipe(const std::string& name, const Eigen::Vector3d& start,
                              const Eigen::Vector3d& direction,
                              std::vector<rack_vision::RadiusAt> radii) {
  rack_vision::Pipe result;
  result.name = name;
  result.start = start;
  result.direction = direction.normalized();
  result.radii = std::move(radii);
  result.movable = false;
  return result;
}

/// T_camera_rack of a camera at `position` that looks down (v against rack y) or up (v along it),
/// turned by `tilt`, a rotation vector in its own frame.
inline geometry::SE3 looking(bool down, const Eigen::Vector3d& position,
                             const Eigen::Vector3d& tilt = Eigen::Vector3d::Zero()) {
  Eigen::Matrix3d R_rack_camera = Eigen::Matrix3d::Identity();
  if (down) {
    R_rack_camera.diagonal() << 1, -1, -1;
  }
  return geometry::SE3(geometry::SO3::from_matrix(R_rack_camera) * geometry::SO3::exp(tilt),
                       position)
      .inverse();
}

/// Four pipes of the paper's set-up, one with a reducer, and supports.
inline rack_vision::RackModel paper_rack() {
  const std::vector<rack_vision::RowPipe> row = {
      {.name = "a", .radii = {{0, 0.15}, {5, 0.15}, {5.4, 0.2}, {10, 0.2}}},
      {.name = "b", .radii = {{0, 0.2}, {10, 0.2}}},
      {.name = "c", .radii = {{0, 0.15}, {10, 0.15}}},
      {.name = "d", .radii = {{0, 0.2}, {10, 0.2}}}};
  rack_vision::RackModel model;
  model.pipes = rack_vision::row_of_pipes(row);
  for (const double y : {1.0, 4.0, 9.0}) {
    model.supports.push_back({.name = "support " + std::to_string(static_cast<int>(y)),
                              .lowest_corner = {-0.4, y - 0.1, -0.2},
                              .highest_corner = {2.0, y + 0.1, 0}});
  }
  return model;
}

}  // namespace pipescout::simulation::test
