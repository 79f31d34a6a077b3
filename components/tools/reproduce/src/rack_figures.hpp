// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <vector>

#include "figure_rows.hpp"
#include "reproduce.hpp"
#include "stage_progress.hpp"

/// The parts of `pipescout reproduce rack`, one source file each.
namespace pipescout::reproduce {

/// What the groups share.
struct RackReproduction {
  const ReproduceOptions& options;
  const RackExtent& extent;
  std::ostream& out;
  Reproduction& result;
  FigureRows& rows;
  StageProgress& progress;
  std::vector<std::uint64_t> seeds;
};

/// Of errors in m or rad; without any 1, which is worse than each.
[[nodiscard]] double error_quantile(const std::vector<double>& errors, double part);

/// Where edges and points are seen is given, with the errors of a detector: the paper's simulation.
void reproduce_rack_features(RackReproduction& run);

/// On rendered images: `image_...` and `silent_wrong_pose`. As many seeds at once as there are
/// processors.
void reproduce_rack_images(RackReproduction& run);

/// On images of two renderers with noise: `noise_grid_...`.
void reproduce_rack_noise(RackReproduction& run);

/// On images of two renderers, over pipes that are not where the rack file has them:
/// `offsets_...`, `fig8_...`, `coverage99_percent`.
void reproduce_rack_offsets(RackReproduction& run);

/// On images of two renderers, over pipes whose heights, directions and radii are not those of the
/// rack file, which states the deviations or does not: `shapes_...`.
void reproduce_rack_shapes(RackReproduction& run);

/// On images of two renderers, with flanges, lagging, valves, a tray and people that the rack file
/// does not have, and with a file that has most of them: `bodies_...`.
void reproduce_rack_bodies(RackReproduction& run);

/// Rolling shutter and fisheye against a global shutter and a pinhole: `row_skew_error_ratio`,
/// `fisheye_error_ratio`.
void reproduce_rack_cameras(RackReproduction& run);

/// A thermal camera and the state estimator on rendered flights: `rack_leaks_...`.
void reproduce_rack_leaks(RackReproduction& run);

}  // namespace pipescout::reproduce
