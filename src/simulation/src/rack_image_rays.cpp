// SPDX-License-Identifier: Apache-2.0
#include "rack_image_rays.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::simulation::internal {

RayTable::RayTable(const geometry::Camera& camera) : stride_(camera.parameters().width + 2) {
  const int width = camera.parameters().width;
  const int height = camera.parameters().height;
  rays_.resize(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height + 2));
  const auto ray = [this](int u, int v) -> Eigen::Vector2f& {
    return rays_[static_cast<std::size_t>((v + 1) * stride_ + u + 1)];
  };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      // A valid camera can be inverted in all corners, so it can within.
      ray(u, v) = camera.ray(Eigen::Vector2d(u, v))
                      .value_or(Eigen::Vector3d::UnitZ())
                      .head<2>()
                      .cast<float>();
    }
    // Beside the image the distortion may not be invertible: continued in a straight line.
    ray(-1, v) = width > 1 ? Eigen::Vector2f(2 * ray(0, v) - ray(1, v)) : ray(0, v);
    ray(width, v) =
        width > 1 ? Eigen::Vector2f(2 * ray(width - 1, v) - ray(width - 2, v)) : ray(0, v);
  }
  for (int u = -1; u <= width; ++u) {
    ray(u, -1) = height > 1 ? Eigen::Vector2f(2 * ray(u, 0) - ray(u, 1)) : ray(u, 0);
    ray(u, height) =
        height > 1 ? Eigen::Vector2f(2 * ray(u, height - 1) - ray(u, height - 2)) : ray(u, 0);
  }
  for (int v0 = 0; v0 < height; v0 += kRayBlock) {
    for (int u0 = 0; u0 < width; u0 += kRayBlock) {
      const int u1 = std::min(u0 + kRayBlock, width);
      const int v1 = std::min(v0 + kRayBlock, height);
      Block block;
      block.cone = cone_around(u0, v0, u1, v1);
      for (int v = v0; v < v1; v += kRayTile) {
        for (int u = u0; u < u1; u += kRayTile) {
          const int u_end = std::min(u + kRayTile, u1);
          const int v_end = std::min(v + kRayTile, v1);
          block.tiles.push_back({u, v, u_end, v_end, cone_around(u, v, u_end, v_end)});
        }
      }
      blocks_.push_back(std::move(block));
    }
  }
}

RayCone RayTable::cone_around(int u, int v, int u_end, int v_end) const {
  RayCone cone;
  cone.axis = at((u + u_end) / 2, (v + v_end) / 2).homogeneous().cast<double>().normalized();
  for (int j = v - 1; j <= v_end; ++j) {
    for (int i = u - 1; i <= u_end; ++i) {
      const Eigen::Vector3d ray = at(i, j).homogeneous().cast<double>();
      const double along = ray.dot(cone.axis);
      const double beside = std::sqrt(std::max(0.0, ray.squaredNorm() - along * along));
      cone.tangent = std::max(cone.tangent, beside / along);
    }
  }
  return cone;
}

}  // namespace pipescout::simulation::internal
