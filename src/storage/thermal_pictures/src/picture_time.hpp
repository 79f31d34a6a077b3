// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pipescout {

/// When an image was taken, from the metadata of its file.
struct PictureTime {
  std::optional<double> taken;      ///< s since 1970 UTC
  std::vector<std::string> doubts;  ///< why it is not, or not exactly, what the file says first
};

/// The tags that `picture_times` reads, as arguments of exiftool.
[[nodiscard]] const std::vector<std::string>& time_tags();

/// Of exiftool's JSON of so many files. The time of FLIR's block where the camera's clock was set,
/// else EXIF's. Throws FlirError for what is not such JSON.
[[nodiscard]] std::vector<PictureTime> picture_times(const std::string& json, std::size_t files);

/// "2018:11:05 12:14:43.084+01:00" in s since 1970 UTC; without an offset it is taken for UTC.
/// Nothing for another text.
[[nodiscard]] std::optional<double> exif_time(const std::string& text);

/// Whether a clock that was set can give this time: before 2001 nobody pressed the shutter of a
/// camera that writes such files.
[[nodiscard]] bool is_plausible_time(double taken) noexcept;

}  // namespace pipescout
