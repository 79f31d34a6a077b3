// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "visp_tracker.hpp"

namespace pipescout::benchmarks {

/// The pipes of a rack as a `.cao` model of ViSP, in the rack frame. Without the supports: most of
/// their edges are hidden by pipes, and ViSP's test for that takes 40 ms an image; without it they
/// mislead it. Throws std::invalid_argument for pipes that are not cylinders: there are no cones.
[[nodiscard]] std::string rack_cao(const rack_vision::RackModel& model);

/// Throws std::invalid_argument for a camera with skew or distortion.
[[nodiscard]] VispCamera visp_camera(const geometry::Camera& camera);

}  // namespace pipescout::benchmarks
