// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/camera.hpp"

#include <stdexcept>
#include <string>
#include <utility>

#include "pipescout/geometry/camera_calibration.hpp"

namespace pipescout {
namespace {

constexpr std::uint32_t kLargestImage = 1 << 16;

}  // namespace

sensor_msgs::msg::CameraInfo to_message(const geometry::CameraParameters& camera) {
  const double fu = camera.focal_length;
  const double fv = camera.aspect_ratio * camera.focal_length;
  sensor_msgs::msg::CameraInfo message;
  message.width = static_cast<std::uint32_t>(camera.width);
  message.height = static_cast<std::uint32_t>(camera.height);
  geometry::RosDistortion distortion = geometry::ros_distortion(camera);
  message.distortion_model = std::move(distortion.model);
  message.d = std::move(distortion.d);
  message.k = {fu, camera.skew, camera.centre_u, 0, fv, camera.centre_v, 0, 0, 1};
  message.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  message.p = {fu, camera.skew, camera.centre_u, 0, 0, fv, camera.centre_v, 0, 0, 0, 1, 0};
  return message;
}

geometry::CameraParameters from_message(const sensor_msgs::msg::CameraInfo& message) {
  const auto& k = message.k;
  if (k[0] == 0) {
    throw std::invalid_argument("k[0] is 0: the camera is not calibrated");
  }
  if (message.width > kLargestImage || message.height > kLargestImage) {
    throw std::invalid_argument("width and height are " + std::to_string(message.width) + " x " +
                                std::to_string(message.height) + "; they must be at most " +
                                std::to_string(kLargestImage));
  }
  geometry::CameraParameters camera;
  camera.width = static_cast<int>(message.width);
  camera.height = static_cast<int>(message.height);
  camera.focal_length = k[0];
  camera.aspect_ratio = k[4] / k[0];
  camera.skew = k[1];
  camera.centre_u = k[2];
  camera.centre_v = k[5];
  geometry::apply_region({.binning_x = message.binning_x,
                          .binning_y = message.binning_y,
                          .x_offset = message.roi.x_offset,
                          .y_offset = message.roi.y_offset,
                          .width = message.roi.width,
                          .height = message.roi.height},
                         camera);
  geometry::set_distortion(message.distortion_model, message.d, camera);
  camera.validate();
  return camera;
}

bool same_calibration(const sensor_msgs::msg::CameraInfo& a,
                      const sensor_msgs::msg::CameraInfo& b) {
  return a.width == b.width && a.height == b.height && a.k == b.k && a.d == b.d &&
         a.distortion_model == b.distortion_model && a.binning_x == b.binning_x &&
         a.binning_y == b.binning_y && a.roi == b.roi;
}

}  // namespace pipescout
