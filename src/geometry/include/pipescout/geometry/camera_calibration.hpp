// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
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

/// Which pixels of the calibrated images are given out, as in sensor_msgs/CameraInfo: those of a
/// region, in pixels of the calibrated images, then binned. Only zeros: all of them.
struct ImageRegion {
  std::uint32_t binning_x = 0;  ///< pixels that become one, along u; 0 and 1: not binned
  std::uint32_t binning_y = 0;
  std::uint32_t x_offset = 0;
  std::uint32_t y_offset = 0;
  std::uint32_t width = 0;  ///< 0 with a height of 0: all of the image
  std::uint32_t height = 0;
};

/// Makes the camera of the calibrated images that of the images given out. Pixel i of a binned
/// image is the mean of the pixels bin * i to bin * i + bin - 1. Throws std::invalid_argument
/// naming `roi` where it reaches beyond the image or is not whole, and `binning_x`, `binning_y`
/// where no pixel is left.
void apply_region(const ImageRegion& region, CameraParameters& camera);

}  // namespace pipescout::geometry
