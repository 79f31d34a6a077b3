// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "pipescout/thermal_files/thermal_file.hpp"

/// Temperatures of an image computed by other software, for comparison.
namespace pipescout {

/// Text of temperatures in degC, row by row from the upper left, as cameras' makers export it:
/// comma-separated, whole or gzipped. Throws ThermalFileError, naming the file, where it cannot be
/// read, is cut short, is larger than 256 MiB or holds what is not a number.
[[nodiscard]] std::vector<float> read_temperature_export(const std::filesystem::path& file);

/// Differences of two images, over all pixels.
struct TemperatureError {
  double mean_abs = 0;  ///< K
  double max_abs = 0;   ///< K
};

/// Infinite when only one of them has a temperature. Throws std::invalid_argument when the numbers
/// of temperatures and pixels differ.
[[nodiscard]] TemperatureError temperature_error(const ThermalPicture& picture,
                                                 std::span<const float> degrees);

}  // namespace pipescout
