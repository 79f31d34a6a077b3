// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace pipescout::leak_findings {

/// Where the surfaces of `lines` are in an image. Lines that go on where the one before ends are
/// one pipe. Left out are parts out of view, and lines that the lens model does not project. None
/// unless all lines have a radius: the other ones would not be found in the image.
[[nodiscard]] std::vector<thermal::PipeStrip> pipe_strips(std::span<const PipeLine> lines,
                                                          const geometry::Camera& camera,
                                                          const geometry::SE3& T_map_camera);

}  // namespace pipescout::leak_findings
