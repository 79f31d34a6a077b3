// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <sensor_msgs/msg/image.hpp>

namespace pipescout::host {

/// The image with each block of `factor` x `factor` pixels as their mean, rounded to the nearest;
/// what is left at the right and lower edge is cut off. Encodings mono8, mono16, rgb8, bgr8, rgba8
/// and bgra8; nothing for another one, an image that is smaller than a block, or one whose data is
/// shorter than its size says. `factor` is at least 1.
[[nodiscard]] std::optional<sensor_msgs::msg::Image> shrink(const sensor_msgs::msg::Image& image,
                                                            int factor);

}  // namespace pipescout::host
