// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/image_view.hpp"

/// Content of the files that say what the camera saw. Pure.
namespace pipescout::summary {

/// The image as a binary PGM file (P5, 8 bits), row by row without padding.
[[nodiscard]] std::string pgm_file(const rack_vision::ImageView& image);

/// The calibration as ROS' camera_calibration and camera_info_manager write and read it, model
/// `plumb_bob`.
[[nodiscard]] std::string camera_yaml(const geometry::CameraParameters& camera);

}  // namespace pipescout::summary
