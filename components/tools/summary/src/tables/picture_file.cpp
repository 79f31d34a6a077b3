// SPDX-License-Identifier: Apache-2.0
#include "tables/picture_file.hpp"

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <variant>
#include <vector>

#include "pipescout/thermal/display_levels.hpp"

namespace pipescout::summary {

std::string picture_file(const ThermalImageReader::View& picture) {
  std::vector<std::uint8_t> bytes;
  const bool encoded = std::visit(
      [&bytes](const auto& image) {
        std::vector<std::uint8_t> levels = thermal::display_levels(image);
        return cv::imencode(".png", cv::Mat(image.height, image.width, CV_8UC1, levels.data()),
                            bytes);
      },
      picture);
  if (!encoded) {
    throw std::invalid_argument("an image cannot be encoded as PNG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace pipescout::summary
