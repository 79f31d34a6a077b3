// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/navigation_maps/path.hpp"
#include "pipescout/planning/motion_primitives.hpp"
#include "pipescout/planning/reeds_shepp.hpp"

namespace pipescout::navigation {

/// A path as arcs from a pose: what the planner joins and cuts.
using ArcList = std::vector<ArcPiece>;

[[nodiscard]] double length_of(const ArcList& arcs);
[[nodiscard]] Pose2d end_of_arcs(const Pose2d& start, const ArcList& arcs);
[[nodiscard]] ArcList arcs_of_word(const SteeringWord& word, double radius);
/// The same way driven back: from its end to its start.
[[nodiscard]] ArcList reversed(const ArcList& arcs);
/// What lies between two lengths.
[[nodiscard]] ArcList cut(const ArcList& arcs, double from, double to);
/// Joins pieces of the same curvature and direction, drops those of no length.
void tidy(ArcList& arcs);
[[nodiscard]] Path sampled(const Pose2d& start, const ArcList& arcs, double step);
/// The arcs between the poses of a path that was sampled from arcs.
[[nodiscard]] ArcList arcs_of_path(const Path& path);

}  // namespace pipescout::navigation
