// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <random>

#include "pipescout/simulation/rack_image.hpp"
#include "rack_image_bodies.hpp"
#include "rack_image_shade.hpp"

namespace pipescout::simulation::internal {

/// A scene in the terms of the ray caster.
struct BuiltScene {
  Bodies bodies;
  Wardrobe wardrobe;
  double axes_height = 0;  ///< mean rack z of the axes of the pipes
  /// Cones of the bodies; each view places them.
  std::size_t first_person = 0;
  std::size_t people = 0;
};

/// `scene` is valid.
[[nodiscard]] BuiltScene build_scene(const RackScene& scene);

/// Tarpaulins and cables over the contours of the pipes: appended to the bodies.
void add_clutter(const rack_vision::RackModel& model, double share, std::mt19937_64& engine,
                 Bodies& bodies);

}  // namespace pipescout::simulation::internal
