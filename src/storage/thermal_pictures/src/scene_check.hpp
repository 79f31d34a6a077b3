// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "pipescout/thermal_files/thermal_file.hpp"

/// Whether temperatures can be those of a scene, or are told in another unit.
namespace pipescout {

/// Of 16-bit counts with a `scale` and of 32-bit temperatures. `missing`: indices, increasing, of
/// pixels without data. Throws ThermalFileError without the file's name where more than half of the
/// others are colder or hotter than any body in view of a thermal camera; it names the scale or the
/// unit that would give usual temperatures, if one does.
void require_scene(const ThermalPicture& picture, std::span<const std::size_t> missing,
                   const ThermalSettings& settings);

/// Of 32-bit temperatures: text for ThermalPicture::unit_doubt.
[[nodiscard]] std::string unit_doubt(const ThermalPicture& picture,
                                     const ThermalSettings& settings);

}  // namespace pipescout
