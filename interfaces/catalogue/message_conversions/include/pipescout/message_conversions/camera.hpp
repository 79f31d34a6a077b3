// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sensor_msgs/msg/camera_info.hpp>

#include "pipescout/geometry/camera.hpp"

namespace pipescout {

/// Calibration of the raw image, with the simplest distortion model that has its lens. Does not
/// fill in the header.
[[nodiscard]] sensor_msgs::msg::CameraInfo to_message(const geometry::CameraParameters& camera);

/// The camera model of the raw images, after binning and region of interest (as
/// geometry::apply_region). The distortion as geometry::set_distortion. Throws
/// std::invalid_argument naming the field: as those functions, for an uncalibrated camera (k[0] is
/// 0, as in ROS), and for values that CameraParameters::validate refuses.
[[nodiscard]] geometry::CameraParameters from_message(const sensor_msgs::msg::CameraInfo& message);

/// Whether both describe the same camera: all fields that `from_message` uses are equal.
[[nodiscard]] bool same_calibration(const sensor_msgs::msg::CameraInfo& a,
                                    const sensor_msgs::msg::CameraInfo& b);

}  // namespace pipescout
