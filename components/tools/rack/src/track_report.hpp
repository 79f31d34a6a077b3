// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "track_run.hpp"

/// The files that `pipescout rack track` writes, as texts.
namespace pipescout::rack {

/// A line for each tracked image: stamp, pose of the camera's optical frame in the rack frame,
/// standard deviations and correlations (pipescout/mission_tables/pose_csv.hpp), and its name, as
/// in `images_csv`.
[[nodiscard]] std::string poses_csv(const TrackRun& run);
/// TUM RGB-D format: stamp x y z qx qy qz qw.
[[nodiscard]] std::string poses_tum(const TrackRun& run);
/// A line for each image: what became of it.
[[nodiscard]] std::string images_csv(const TrackRun& run);
/// Markdown. `said`: what was taken for what, before the sentences of the run.
[[nodiscard]] std::string report(const TrackRun& run, const std::vector<std::string>& said);

}  // namespace pipescout::rack
