// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/navigation_maps/occupancy_grid.hpp"

namespace pipescout {

/// A file of a map is missing, malformed, or says what cannot be: "file: field ...".
class MapFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How the shade of a pixel is read, as map_server's `mode`.
enum class GridMode {
  kTrinary,  ///< darker than occupied_thresh, lighter than free_thresh, or unknown
  kScale,    ///< the same; shades between are graded there, and unknown here
  kRaw       ///< the value of the pixel is the occupancy in percent; above 100: unknown
};

/// An occupancy grid of map_server's YAML file and its image: PGM (P2 or P5, 8 bits), PNG, BMP and
/// what else OpenCV reads, grey or in colours. Keys: image, mode (trinary where it is missing),
/// resolution in m, origin [x, y, yaw] of the lower left pixel in m and rad, negate,
/// occupied_thresh, free_thresh. Colours are averaged; alpha is averaged with them in mode trinary,
/// what is not opaque is unknown in mode scale, and alpha does not count in mode raw, as in
/// nav2_map_server (map_io.cpp). `remarks` gets a sentence, with file and line, for each thing that
/// is read and is probably not meant: what was saved as unknown, and is free by free_thresh.
/// `resolution`: what the grid must have, where the caller relies on it. Throws MapFileError or
/// YamlError, both name file and field.
[[nodiscard]] navigation::OccupancyGrid read_grid(const std::filesystem::path& yaml,
                                                  std::vector<std::string>& remarks,
                                                  std::optional<double> resolution = {});

/// An image that has no YAML file, with the thresholds of ROS 1: occupied above 0.65, free below
/// 0.196, so that its grey (205) is unknown; resolution in m, origin at the lower left pixel.
/// Throws MapFileError naming the file, also for an image whose alpha makes that grey free;
/// std::invalid_argument for a resolution outside (0, 1000].
[[nodiscard]] navigation::OccupancyGrid read_grid_image(const std::filesystem::path& path,
                                                        double resolution);

/// Writes `yaml` and, next to it, the image of the same name with `.pgm`. Reading them gives the
/// same grid. Throws std::system_error naming the file.
void write_grid(const std::filesystem::path& yaml, const navigation::OccupancyGrid& grid,
                GridMode mode = GridMode::kTrinary);

}  // namespace pipescout
