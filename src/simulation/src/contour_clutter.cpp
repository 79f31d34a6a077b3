// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/contour_clutter.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "pipescout/rack_vision/visible_edges.hpp"

namespace pipescout::simulation {

double cluttered_contour_share(RackScene scene, const geometry::Camera& camera,
                               std::span<const geometry::SE3> views) {
  constexpr int kSameLevel = 1;  // grey level: rounding
  constexpr double kMargin = 2;  // px
  scene.shadows = false;
  RackImageRenderer cluttered(scene, camera, perfect_image_sensor());
  scene.clutter_share = 0;
  RackImageRenderer clear(scene, camera, perfect_image_sensor());
  const auto width = static_cast<std::size_t>(camera.parameters().width);
  std::vector<std::uint8_t> with(width * static_cast<std::size_t>(camera.parameters().height));
  std::vector<std::uint8_t> without(with.size());
  rack_vision::EdgeRenderer contours;
  std::vector<rack_vision::VisibleEdge> edges;
  std::size_t all = 0;
  std::size_t changed = 0;
  for (const geometry::SE3& T_camera_rack : views) {
    cluttered.render({.T_camera_rack = T_camera_rack}, with);
    clear.render({.T_camera_rack = T_camera_rack}, without);
    contours.render(scene.model, {}, camera, T_camera_rack, edges);
    for (const rack_vision::VisibleEdge& edge : edges) {
      if (edge.id.kind != rack_vision::EdgeKind::kPipe) {
        continue;
      }
      // Contours are straight on pipes and cones.
      const auto steps = std::lround((edge.image_end - edge.image_start).norm());
      for (long i = 0; i < steps; ++i) {
        const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(steps);
        const auto seen =
            camera.project(T_camera_rack * (edge.start + at * (edge.end - edge.start)));
        if (!seen || !camera.contains(*seen, kMargin)) {
          continue;
        }
        const auto index = static_cast<std::size_t>(std::lround(seen->y())) * width +
                           static_cast<std::size_t>(std::lround(seen->x()));
        ++all;
        changed += std::abs(with[index] - without[index]) > kSameLevel ? 1U : 0U;
      }
    }
  }
  return all == 0 ? 0.0 : static_cast<double>(changed) / static_cast<double>(all);
}

}  // namespace pipescout::simulation
