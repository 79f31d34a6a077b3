// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "pipescout/thermal_files/thermal_file.hpp"

/// Temperatures of a picture as other software has computed them, to compare with.
namespace pipescout {

/// Text of temperatures in degC, row by row from the upper left, as cameras' makers export it:
/// comma-separated, whole or gzipped. Throws ThermalFileError, naming the file, where it cannot be
/// read, is cut short, is larger than 256 MiB or holds what is not a number.
[[nodiscard]] std::vector<float> read_temperature_export(const std::filesystem::path& file);

/// Of two pictures, over all pixels.
struct TemperatureError {
  double mean_abs = 0;  ///< K
  double max_abs = 0;   ///< K
};

/// Infinite where one has a temperature and the other has none: that is an error too. Throws
/// std::invalid_argument where there are not as many temperatures as pixels.
[[nodiscard]] TemperatureError temperature_error(const ThermalPicture& picture,
                                                 std::span<const float> degrees);

}  // namespace pipescout
