// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/camera.hpp"

#include <algorithm>
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
  const double bin_u = std::max(1U, message.binning_x);
  const double bin_v = std::max(1U, message.binning_y);
  const auto& roi = message.roi;
  const bool cut = roi.width != 0 && roi.height != 0;
  if (cut && (roi.x_offset + std::uint64_t{roi.width} > message.width ||
              roi.y_offset + std::uint64_t{roi.height} > message.height)) {
    throw std::invalid_argument("roi reaches beyond the image");
  }
  geometry::CameraParameters camera;
  camera.width = static_cast<int>((cut ? roi.width : message.width) / bin_u);
  camera.height = static_cast<int>((cut ? roi.height : message.height) / bin_v);
  // Pixel i of a binned image is the mean of the raw pixels bin * i to bin * i + bin - 1.
  camera.focal_length = k[0] / bin_u;
  camera.aspect_ratio = k[4] / bin_v / camera.focal_length;
  camera.skew = k[1] / bin_u;
  camera.centre_u = (k[2] - (cut ? roi.x_offset : 0) - 0.5 * (bin_u - 1)) / bin_u;
  camera.centre_v = (k[5] - (cut ? roi.y_offset : 0) - 0.5 * (bin_v - 1)) / bin_v;
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
