// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "image_source.hpp"

namespace pipescout::rack {

/// Images per second of a folder that has no times.
inline constexpr double kAssumedRate = 30;

struct FolderTimes {
  std::optional<double> rate;                  ///< images per second; decides when given
  std::optional<std::filesystem::path> table;  ///< CSV with the columns `image` and `stamp` (s)
};

/// The images of a folder (PNG, JPEG, PGM, PPM, BMP, TIFF). Their times: the rate or the table that
/// is given; else `times.csv` in the folder; else the times in their names, where all names end
/// with one; else kAssumedRate, in the natural order of the names. Throws std::runtime_error naming
/// the folder when there is no image in it, CsvError for the table.
[[nodiscard]] std::unique_ptr<ImageSource> open_folder(const std::filesystem::path& folder,
                                                       const FolderTimes& times);

/// Whether `a` is before `b` where numbers in them count as numbers: "img_2" is before "img_10".
[[nodiscard]] bool natural_less(std::string_view a, std::string_view b);

/// The time at the end of a file's name without extension: seconds since 1970 with a decimal point,
/// or milli-, micro- or nanoseconds, by the number of digits (13, 16 or 19).
[[nodiscard]] std::optional<Stamp> time_in_name(std::string_view stem);

}  // namespace pipescout::rack
