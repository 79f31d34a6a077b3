// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "image_source.hpp"
#include "pipescout/geometry/camera.hpp"

namespace pipescout::rack {

/// The images of one topic of a bag, `sensor_msgs/Image` or `sensor_msgs/CompressedImage`, in the
/// order of their recording, with the times of their headers (or of the recording where a header
/// has none). `topic`: empty for the only one. Throws std::runtime_error when there is no such
/// topic, or none was chosen of several; bags::BagError for a bag that cannot be read.
[[nodiscard]] std::unique_ptr<ImageSource> open_bag(const std::filesystem::path& bag,
                                                    const std::string& topic);

struct BagCamera {
  geometry::CameraParameters camera;
  std::string topic;
};

/// The first calibration in the namespace of the image topic (`camera_info`,
/// sensor_msgs/CameraInfo) of such a bag; nothing where there is none. Throws as `open_bag`, and
/// std::runtime_error naming topic and field for a calibration that is not usable.
[[nodiscard]] std::optional<BagCamera> camera_of_bag(const std::filesystem::path& bag,
                                                     const std::string& topic);

}  // namespace pipescout::rack
