// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sensor_msgs/msg/camera_info.hpp>

#include "pipescout/geometry/camera.hpp"

namespace pipescout {

/// Calibration of the raw image, model `plumb_bob`. The header is left to the caller.
[[nodiscard]] sensor_msgs::msg::CameraInfo to_message(const geometry::CameraParameters& camera);

/// The camera that took the raw images: binning and region of interest are allowed for.
/// `distortion_model` is `plumb_bob` with up to five coefficients, `rational_polynomial` whose
/// denominator is 1, or empty with no coefficients that are not 0.
/// Throws std::invalid_argument naming the field: another model, more coefficients, an uncalibrated
/// camera (k[0] is 0, as ROS says it), and what CameraParameters::validate refuses.
[[nodiscard]] geometry::CameraParameters from_message(const sensor_msgs::msg::CameraInfo& message);

/// Whether both are of one camera, the same in all that `from_message` looks at.
[[nodiscard]] bool same_calibration(const sensor_msgs::msg::CameraInfo& a,
                                    const sensor_msgs::msg::CameraInfo& b);

}  // namespace pipescout
