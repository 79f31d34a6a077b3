// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"

namespace pipescout::rack {

/// Pictures of the rack's model over the images: contours of pipes, edges of supports.
class Overlay {
 public:
  Overlay(const rack_vision::RackModel& model, const geometry::Camera& camera);

  /// Writes a PNG: the visible edges at the pose of a tracked image, and a line of text that says
  /// how it was tracked or why not. Throws std::runtime_error naming the file.
  void write(const std::filesystem::path& file, const rack_vision::ImageView& image,
             const rack_vision::RackTrackerResult& result);

 private:
  rack_vision::RackModel drawn_;  ///< as the rack file has it
  rack_vision::RackModel model_;  ///< with the shapes that were found
  const geometry::Camera& camera_;
  rack_vision::EdgeRenderer renderer_;
  std::vector<rack_vision::VisibleEdge> edges_;
};

}  // namespace pipescout::rack
