// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>

#include "image_source.hpp"
#include "pipescout/tracking/shape_tracker.hpp"

namespace pipescout::track {

/// Writes a PNG of the image in grey levels, small ones enlarged: the axes of the detected pipes in
/// blue; the outline of the track, green where it is locked and orange where it is predicted; and a
/// line of text that says how it is tracked. Throws std::runtime_error naming the file.
void write_overlay(const std::filesystem::path& file, const SourceImage& image,
                   std::span<const tracking::PipeRegion> regions, const tracking::PipeTrack& track);

}  // namespace pipescout::track
