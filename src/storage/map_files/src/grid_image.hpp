// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace pipescout {

/// The image of an occupancy grid, as shades between black (0) and `white`.
struct GridImage {
  int width = 0;
  int height = 0;
  std::uint32_t white = 0;
  std::vector<std::uint32_t> shades;  ///< top row first
  std::vector<bool> transparent;      ///< not wholly opaque; empty: the image has no alpha
  /// What an opaque pixel of the grey 205 of 255 has, which map savers write for "unknown".
  std::uint32_t saved_unknown = 0;
};

/// Of an image with alpha: whether it counts as a fourth colour, as in map_server's mode trinary.
enum class AlphaUse : std::uint8_t { kAveraged, kSeparate };

/// PGM (P2 or P5, 8 bits), and what OpenCV reads: PNG, BMP and more, grey or in colours, 8 or 16
/// bits. `content`: of the file `path`. Throws MapFileError naming the file.
[[nodiscard]] GridImage decode_grid_image(const std::string& content,
                                          const std::filesystem::path& path, AlphaUse alpha);

}  // namespace pipescout
