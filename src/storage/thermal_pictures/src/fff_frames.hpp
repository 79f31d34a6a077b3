// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "pipescout/thermal_files/thermal_file.hpp"

namespace pipescout {

/// The frames of a file of FLIR's FFF format, one for a still image and one after the other in a
/// sequence (SEQ, CSQ). A frame is a header, a directory of records and the records; it ends with
/// the last of them, and the next one begins at the next header. Empty where the file begins with
/// no such header, or cannot be read.
[[nodiscard]] std::vector<FrameExtent> fff_frames(const std::filesystem::path& file);

}  // namespace pipescout
