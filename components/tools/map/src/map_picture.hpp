// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "pipescout/navigation_maps/hybrid_map.hpp"

namespace pipescout::map {

/// What is drawn over each other.
struct MapPicture {
  std::vector<std::string> remarks;  ///< of the files
  navigation::OccupancyGrid grid;
  std::optional<navigation::RouteGraph> graph;
  std::vector<navigation::MapProblem> problems;
};

/// Writes a picture with `scale` pixels along the edge of a cell, x of the grid to the right: free
/// cells white, obstacles dark, unknown ones grey; edges as arrows, blue, green where pipes stand
/// along them, orange where closed; nodes as dots with their ids; problems as red circles. The kind
/// of file follows from its name. Throws std::runtime_error naming a file that cannot be written,
/// and std::invalid_argument for more than 1e8 pixels.
void draw_map(const std::filesystem::path& file, const MapPicture& picture, int scale);

}  // namespace pipescout::map
