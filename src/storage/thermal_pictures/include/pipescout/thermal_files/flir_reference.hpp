// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "pipescout/thermal_files/temperature_export.hpp"

/// A data set of pictures of five FLIR cameras, beside what other software makes of them.
namespace pipescout {

/// Of one picture the temperatures were exported by two programs of the camera's maker; of all five
/// there are pictures of 16 bits, hundredths of a degree from -100 degC on.
struct FlirReferenceErrors {
  TemperatureError thermacam;  ///< ThermaCAM, emissivity 0.96; it prints tenths of a degree
  TemperatureError research;   ///< FLIR R&D Software, with what the file says; thousandths
  TemperatureError decoded;    ///< of the five pictures: the largest of each
};

/// The file by which one knows that the data set is there.
inline constexpr const char* kFlirReferenceFile = "iguana_sc660.jpg";

/// Throws ThermalFileError for a file that is missing, cut short or of another kind.
[[nodiscard]] FlirReferenceErrors score_flir_reference(const std::filesystem::path& folder);

}  // namespace pipescout
