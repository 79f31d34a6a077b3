// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace pipescout {

/// What to export instead of a picture in colours, by the maker of its camera, if EXIF has it.
/// Throws ExiftoolError.
[[nodiscard]] std::string colour_advice(const std::string& exiftool,
                                        std::span<const std::uint8_t> content);

}  // namespace pipescout
