// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <sensor_msgs/msg/image.hpp>
#include <variant>
#include <vector>

#include "pipescout/thermal/image.hpp"

namespace pipescout {

/// Reads images of thermal cameras: `mono16` and `16UC1` as counts, `32FC1` as degC, `mono8` and
/// `8UC1` as grey levels. Pixels are used without a copy, unless they are unaligned or in the other
/// byte order; then they are copied into a buffer that is reused.
class ThermalImageReader {
 public:
  using View = std::variant<thermal::CountView, thermal::TemperatureView, thermal::GreyView>;

  /// Valid as long as the message and until the next call. Throws std::invalid_argument naming the
  /// field for another encoding, no pixels, a `step` shorter than a row, `data` that is shorter
  /// than `step * height`.
  [[nodiscard]] View read(const sensor_msgs::msg::Image& message);

 private:
  template <class Pixel>
  [[nodiscard]] thermal::ImageView<Pixel> view(const sensor_msgs::msg::Image& message,
                                               std::vector<Pixel>& copy);

  std::vector<std::uint16_t> counts_;
  std::vector<float> temperatures_;
  std::vector<std::uint8_t> grey_;
};

}  // namespace pipescout
