// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/simulation/rack_image.hpp"

namespace pipescout::simulation {

/// Share of the contours of the pipes that tarpaulins hide or cables imitate, measured in rendered
/// images: of the pixels on contours in those views (T_camera_rack), the share whose grey level
/// differs from that without clutter. Shadows, lens and noise are disabled, because they are not
/// clutter. 0 when no contour is in view. Throws as RackImageRenderer.
[[nodiscard]] double cluttered_contour_share(RackScene scene, const geometry::Camera& camera,
                                             std::span<const geometry::SE3> views);

}  // namespace pipescout::simulation
