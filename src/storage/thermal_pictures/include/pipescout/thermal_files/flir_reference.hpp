// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "pipescout/thermal_files/temperature_export.hpp"

/// A data set of images of five FLIR cameras, with temperatures by other software.
namespace pipescout {

/// For one image the temperatures were exported by two programs of the manufacturer; for all five
/// there are 16-bit images in hundredths of a degree from -100 degC on.
struct FlirReferenceErrors {
  TemperatureError thermacam;  ///< ThermaCAM, emissivity 0.96; it prints tenths of a degree
  TemperatureError research;   ///< FLIR R&D Software, with the parameters of the file; thousandths
  TemperatureError decoded;    ///< of the five images: the largest of each
};

/// A file whose existence shows that the data set is available.
inline constexpr const char* kFlirReferenceFile = "iguana_sc660.jpg";

/// Throws ThermalFileError for a file that is missing, truncated or of another kind.
[[nodiscard]] FlirReferenceErrors score_flir_reference(const std::filesystem::path& folder);

}  // namespace pipescout
