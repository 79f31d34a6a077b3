// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/thermal/radiometry.hpp"
#include "pipescout/thermal_files/thermal_file.hpp"
#include "pixel_file.hpp"

namespace pipescout {

/// What() says what is wrong, without the file's name.
class FlirError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What is in a FLIR file.
struct FlirContent {
  Pixels<std::uint16_t> counts;
  thermal::CameraConstants camera;
  thermal::ObjectParameters object;
  thermal::CountRange range;
  std::optional<double> taken;
  std::optional<GeographicPlace> place;
  std::string camera_name;
  std::string lens;
  std::vector<std::string> doubts;
};

/// The tags that `flir_content` reads, as arguments of exiftool.
[[nodiscard]] const std::vector<std::string>& flir_tags();

/// Of exiftool's JSON. Nothing where there is no thermal block; `complaint` then says what exiftool
/// has to say, if anything. Throws FlirError where the block is not whole.
[[nodiscard]] std::optional<FlirContent> flir_content(const std::string& json,
                                                      std::string& complaint);

}  // namespace pipescout
