// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/camera.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace pipescout {
namespace {

constexpr std::uint32_t kLargestImage = 1 << 16;

void read_distortion(const sensor_msgs::msg::CameraInfo& message,
                     geometry::CameraParameters& camera) {
  const std::string& model = message.distortion_model;
  if (!model.empty() && model != "plumb_bob" && model != "rational_polynomial") {
    throw std::invalid_argument("distortion_model is '" + model +
                                "'; it must be plumb_bob or rational_polynomial");
  }
  const auto& d = message.d;
  const std::size_t used = model.empty() ? 0 : 5;
  for (std::size_t i = used; i < d.size(); ++i) {
    if (d[i] != 0) {
      throw std::invalid_argument("d[" + std::to_string(i) + "] is " + std::to_string(d[i]) +
                                  "; it must be 0 with the distortion_model '" + model + "'");
    }
  }
  const auto coefficient = [&](std::size_t i) { return i < std::min(used, d.size()) ? d[i] : 0; };
  camera.k1 = coefficient(0);
  camera.k2 = coefficient(1);
  camera.p1 = coefficient(2);
  camera.p2 = coefficient(3);
  camera.k3 = coefficient(4);
}

}  // namespace

sensor_msgs::msg::CameraInfo to_message(const geometry::CameraParameters& camera) {
  const double fu = camera.focal_length;
  const double fv = camera.aspect_ratio * camera.focal_length;
  sensor_msgs::msg::CameraInfo message;
  message.width = static_cast<std::uint32_t>(camera.width);
  message.height = static_cast<std::uint32_t>(camera.height);
  message.distortion_model = "plumb_bob";
  message.d = {camera.k1, camera.k2, camera.p1, camera.p2, camera.k3};
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
  read_distortion(message, camera);
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
