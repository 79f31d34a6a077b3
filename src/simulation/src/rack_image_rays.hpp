// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "rack_image_bodies.hpp"

namespace pipescout::simulation::internal {

inline constexpr int kRayTile = 16;  // pixels; a tile is one batch
inline constexpr int kRayBlock = 128;
static_assert(std::size_t{kRayTile} * kRayTile <= kBatch);

/// Where the rays of a camera go: computed once, the distortion too.
class RayTable {
 public:
  struct Tile {
    int u = 0;
    int v = 0;
    int u_end = 0;
    int v_end = 0;
    RayCone cone;  ///< around all rays of the tile, camera frame
  };
  struct Block {
    std::vector<Tile> tiles;
    RayCone cone;
  };

  explicit RayTable(const geometry::Camera& camera);

  /// (x, y) of the ray (x, y, 1) of a pixel; those next to the image too, -1 <= u <= width.
  [[nodiscard]] const Eigen::Vector2f& at(int u, int v) const noexcept {
    return rays_[static_cast<std::size_t>((v + 1) * stride_ + u + 1)];
  }
  [[nodiscard]] const std::vector<Block>& blocks() const noexcept { return blocks_; }

 private:
  [[nodiscard]] RayCone cone_around(int u, int v, int u_end, int v_end) const;

  int stride_;
  std::vector<Eigen::Vector2f> rays_;
  std::vector<Block> blocks_;
};

}  // namespace pipescout::simulation::internal
