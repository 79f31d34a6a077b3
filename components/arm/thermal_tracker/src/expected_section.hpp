// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/tracking/shape_tracker.hpp"

namespace pipescout {

/// Where a pipe of the map should be seen.
struct ExpectedSection {
  tracking::TrackHint<tracking::PipeShape> hint;
  double depth = 0;  ///< m, of its middle along the axis of the camera
};

/// Of the pipes whose lines are in view, the nearest. `pose`: of the robot; `line_deviation`: m,
/// standard, of pipes from their lines. Along the pipe little is said, for posts may hide parts of
/// it. Nothing when none is in view. Pure.
[[nodiscard]] std::optional<ExpectedSection> expected_section(
    std::span<const leak_findings::PipeLine> lines, double line_deviation,
    const geometry::Camera& camera, const leak_findings::FramePose& pose,
    const geometry::SE3& T_base_camera);

}  // namespace pipescout
