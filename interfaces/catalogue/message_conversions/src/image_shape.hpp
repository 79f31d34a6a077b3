// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <sensor_msgs/msg/image.hpp>
#include <stdexcept>
#include <string>

namespace pipescout {

/// Throws std::invalid_argument naming the field unless the message holds as many pixels of this
/// size as it says.
inline void require_shape(const sensor_msgs::msg::Image& message, std::size_t bytes_per_pixel) {
  const std::size_t width = message.width;
  const std::size_t height = message.height;
  const std::size_t step = message.step;
  constexpr std::size_t kLargest = 1 << 16;
  if (width == 0 || height == 0 || width > kLargest || height > kLargest) {
    throw std::invalid_argument("width and height are " + std::to_string(width) + " x " +
                                std::to_string(height));
  }
  if (step < width * bytes_per_pixel) {
    throw std::invalid_argument("step is " + std::to_string(step) + "; a row has " +
                                std::to_string(width * bytes_per_pixel) + " bytes");
  }
  if (message.data.size() < step * height) {
    throw std::invalid_argument("data has " + std::to_string(message.data.size()) +
                                " bytes; step * height is " + std::to_string(step * height));
  }
}

}  // namespace pipescout
