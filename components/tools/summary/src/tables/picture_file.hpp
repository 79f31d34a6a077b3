// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/message_conversions/thermal_image.hpp"

namespace pipescout::summary {

/// A thermal picture as a PNG file of 8-bit grey, to look at: black and white are the values that 1
/// and 0.1 percent of the pixels are beyond. Values that are not finite are black. Pure. Throws
/// std::invalid_argument when it cannot be encoded.
[[nodiscard]] std::string picture_file(const ThermalImageReader::View& picture);

}  // namespace pipescout::summary
