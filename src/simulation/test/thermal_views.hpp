// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipescout/simulation/thermal_camera.hpp"
#include "pipescout/simulation/thermal_patrol.hpp"

/// Scenes and cameras of which closed forms are known.
namespace pipescout::simulation::test {

/// A tube of 150 degC before a wall that is as cold everywhere; nothing else.
inline ThermalSceneParameters bare_scene() {
  ThermalSceneParameters scene;
  scene.length = 40;
  scene.tube_change = 0;
  scene.tube_grain = 0;
  scene.joint_width = 0;
  scene.support_width = 0;
  scene.swivel_joints = false;
  // Beyond the upper border of all views.
  scene.mirror_image_offset = 5;
  scene.sky_temperature = -10;
  scene.ground_temperature = -10;
  scene.ground_grain = 0;
  scene.mirror_temperature = -10;
  scene.mirror_change = 0;
  // No gaps and seams of another temperature either, as sky and ground have the same.
  return scene;
}

/// Without noise, blur and dead pixels.
inline ThermalCameraParameters perfect_camera() {
  ThermalCameraParameters camera = ThermalCameraParameters::qvga();
  camera.netd = 0;
  camera.fixed_pattern = 0;
  camera.exposure = 0;
  camera.lens_blur = 0;
  camera.dead_share = 0;
  camera.highest = 1000;
  return camera;
}

/// At a place along the row, 10 m before the tube, as high as it; turned by roll about its axis.
inline ThermalView level_view(double place, double height = 3, double roll = 0) {
  ThermalView view;
  const geometry::SE3 mounting = T_body_side_camera({0, 0, 0}, 0);
  view.T_map_camera = {mounting.rotation() * geometry::SO3::exp(Eigen::Vector3d(0, 0, roll)),
                       {place, -10, height}};
  return view;
}

class ThermalImage {
 public:
  ThermalImage(ThermalRenderer& renderer, const ThermalView& view)
      : width_(renderer.camera().parameters().width),
        counts_(static_cast<std::size_t>(width_) *
                static_cast<std::size_t>(renderer.camera().parameters().height)) {
    renderer.render(view, counts_);
  }
  [[nodiscard]] double operator()(int x, int y) const {
    return counts_[static_cast<std::size_t>(y * width_ + x)];
  }
  [[nodiscard]] double at(const Eigen::Vector2d& pixel) const {
    return (*this)(static_cast<int>(std::lround(pixel.x())),
                   static_cast<int>(std::lround(pixel.y())));
  }
  [[nodiscard]] const std::vector<std::uint16_t>& counts() const { return counts_; }

 private:
  int width_;
  std::vector<std::uint16_t> counts_;
};

}  // namespace pipescout::simulation::test
