// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/geometry/camera.hpp"

/// Lens models as ROS names them, in sensor_msgs/CameraInfo and in the files of camera_calibration.
/// All functions are pure and thread-safe.
namespace pipescout::geometry {

/// Sets lens and coefficients: `plumb_bob` (k1, k2, p1, p2, k3), `rational_polynomial` (k1, k2, p1,
/// p2, k3, k4, k5, k6), `equidistant` (k1 to k4), or an empty name with no coefficients. Missing
/// ones are 0, further ones must be 0. Throws std::invalid_argument naming `distortion_model` or
/// `d[i]`, the value and the range.
void set_distortion(std::string_view distortion_model, std::span<const double> d,
                    CameraParameters& camera);

/// The simplest of these models that has the camera's lens.
struct RosDistortion {
  std::string model;
  std::vector<double> d;
};
[[nodiscard]] RosDistortion ros_distortion(const CameraParameters& camera);

}  // namespace pipescout::geometry
