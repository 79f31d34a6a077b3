// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/geometry/camera.hpp>
#include <string>
#include <vector>

/// Calibrations of cameras as ROS' camera_calibration writes them and camera_info_manager reads
/// them.
namespace pipescout {

/// Reads the calibration of the raw images: `image_width`, `image_height`, `camera_matrix`,
/// `distortion_model` (as geometry::set_distortion) and `distortion_coefficients`; `binning_x`,
/// `binning_y` and `roi`, where they are given, as geometry::apply_region. Without
/// `distortion_model`, `camera_model: fisheye` is the equidistant one. Other fields (`camera_name`,
/// `rectification_matrix`, `projection_matrix`, ...) are not used. `remarks` gets a sentence, with
/// the file, for what was taken in another way than it is written. Throws YamlError
/// (pipescout/files/yaml_location.hpp) naming file, line and field: a file that cannot be read or
/// is not YAML, missing fields, wrong types and sizes, a camera that is not calibrated, and what
/// geometry::CameraParameters::validate refuses.
[[nodiscard]] geometry::CameraParameters read_camera(const std::string& path,
                                                     std::vector<std::string>& remarks);

/// The same from a text. `path` names it in errors.
[[nodiscard]] geometry::CameraParameters parse_camera(const std::string& text,
                                                      const std::string& path,
                                                      std::vector<std::string>& remarks);

}  // namespace pipescout
