// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "configuration.hpp"
#include "recording.hpp"
#include "replay.hpp"

/// The files that `pipescout estimate` writes, as texts.
namespace pipescout::estimate {

/// stamp, position and its deviations, orientation, velocity; latitude and longitude with GPS.
[[nodiscard]] std::string trajectory_csv(const Recording& recording, const Trajectory& trajectory);
/// TUM RGB-D format: stamp x y z qx qy qz qw.
[[nodiscard]] std::string trajectory_tum(const Recording& recording, const Trajectory& trajectory);
/// RFC 7946, cut at the antimeridian (3.1.9). Empty without GPS.
[[nodiscard]] std::string trajectory_geojson(const Trajectory& trajectory);
/// Plan view of trajectory and fixes, of which there is one at least, with axes in metres of the
/// map.
[[nodiscard]] std::string trajectory_svg(const Trajectory& trajectory);
/// Markdown. `said`: what was taken for what.
[[nodiscard]] std::string report(const Recording& recording, const Configuration& configuration,
                                 const Trajectory& trajectory,
                                 const std::vector<std::string>& said);

}  // namespace pipescout::estimate
