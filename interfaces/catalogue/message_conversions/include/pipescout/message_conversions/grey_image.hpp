// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <sensor_msgs/msg/image.hpp>
#include <vector>

#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout {

/// Reads images as 8-bit grey. `mono8` and `8UC1` are used without a copy; `rgb8`, `bgr8`, `rgba8`,
/// `bgra8` and their OpenCV names are converted into a buffer that is reused.
class GreyImageReader {
 public:
  /// Valid as long as the message and until the next call. Throws std::invalid_argument naming the
  /// field for another encoding, no pixels, a `step` shorter than a row, `data` that is shorter
  /// than `step * height`.
  [[nodiscard]] rack_vision::ImageView read(const sensor_msgs::msg::Image& message);

 private:
  std::vector<std::uint8_t> grey_;
};

}  // namespace pipescout
