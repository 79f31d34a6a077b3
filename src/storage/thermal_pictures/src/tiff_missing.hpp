// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace pipescout {

/// The value that pixels without data have, which geographic software writes as text into the tag
/// GDAL_NODATA (42113) of the first image of a TIFF file. Nothing without that tag, and for bytes
/// that are no TIFF; NaN where the tag says so.
[[nodiscard]] std::optional<double> tiff_missing_value(std::span<const std::uint8_t> tiff);

}  // namespace pipescout
