// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/thermal_files/thermal_file.hpp"

namespace pipescout {

/// An image of a folder: a file, or a frame of a sequence.
struct FolderPicture {
  std::filesystem::path file;
  std::shared_ptr<const std::vector<FrameExtent>> frames;  ///< of the file
  std::size_t frame = 0;                                   ///< index in them
  std::optional<double> taken;  ///< of the file or frame, s since 1970 UTC

  /// Of the file; of a sequence with the number of the frame, from 1 on: "rec.seq#3".
  [[nodiscard]] std::string name() const;
};

struct PictureFolder {
  std::vector<FolderPicture> pictures;
  std::vector<std::string> unread;  ///< names of thermal recordings in formats that are not read
  std::string problem;              ///< why times of files are unknown; else empty
};

/// Times that are known better than by the files, s since 1970 UTC, by the name of an image.
using ToldTimes = std::function<std::optional<double>(const std::string& name)>;

/// The images of a folder in the order in which they were taken, as far as `told` or the files
/// tell; images of the same time in the natural order of their names, those without a time at the
/// end. Throws std::runtime_error for a folder that cannot be read or has no image.
[[nodiscard]] PictureFolder pictures_in(const std::filesystem::path& folder, const ToldTimes& told,
                                        const ThermalFileReader& reader);

/// Whether `a` comes before `b` in the order in which people count: IMG_2 before IMG_10.
[[nodiscard]] bool natural_less(const std::string& a, const std::string& b);

}  // namespace pipescout
