// SPDX-License-Identifier: Apache-2.0
#include "tables/camera_files.hpp"

#include <cstddef>
#include <span>

#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/message_conversions/camera.hpp"

namespace pipescout::summary {

namespace {

std::string matrix(const char* name, std::size_t rows, std::span<const double> values) {
  std::string text = std::string(name) + ":\n  rows: " + std::to_string(rows) +
                     "\n  cols: " + std::to_string(values.size() / rows) + "\n  data: [";
  for (std::size_t k = 0; k < values.size(); ++k) {
    text += (k == 0 ? "" : ", ") + format_csv_number(values[k]);
  }
  return text + "]\n";
}

}  // namespace

std::string pgm_file(const rack_vision::ImageView& image) {
  const auto width = static_cast<std::size_t>(image.width);
  const auto height = static_cast<std::size_t>(image.height);
  std::string file = "P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  file.reserve(file.size() + width * height);
  for (std::size_t row = 0; row < height; ++row) {
    const std::uint8_t* const pixels = image.row(static_cast<int>(row));
    file.append(pixels, pixels + width);
  }
  return file;
}

std::string camera_yaml(const geometry::CameraParameters& camera) {
  const auto message = to_message(camera);
  return "image_width: " + std::to_string(message.width) +
         "\nimage_height: " + std::to_string(message.height) + "\ncamera_name: camera\n" +
         matrix("camera_matrix", 3, message.k) + "distortion_model: " + message.distortion_model +
         "\n" + matrix("distortion_coefficients", 1, message.d) +
         matrix("rectification_matrix", 3, message.r) + matrix("projection_matrix", 3, message.p);
}

}  // namespace pipescout::summary
