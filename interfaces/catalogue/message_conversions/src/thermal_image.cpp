// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/thermal_image.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

#include "image_shape.hpp"

namespace pipescout {

template <class Pixel>
thermal::ImageView<Pixel> ThermalImageReader::view(const sensor_msgs::msg::Image& message,
                                                   std::vector<Pixel>& copy) {
  require_shape(message, sizeof(Pixel));
  const std::size_t width = message.width;
  const std::size_t height = message.height;
  const std::size_t step = message.step;
  const std::uint8_t* const data = message.data.data();
  const bool swapped =
      sizeof(Pixel) > 1 && (message.is_bigendian != 0) != (std::endian::native == std::endian::big);
  const bool aligned = std::bit_cast<std::uintptr_t>(data) % alignof(Pixel) == 0;
  if (!swapped && aligned && step % sizeof(Pixel) == 0) {
    return {reinterpret_cast<const Pixel*>(data), static_cast<int>(width), static_cast<int>(height),
            static_cast<std::ptrdiff_t>(step / sizeof(Pixel))};
  }
  copy.resize(width * height);
  for (std::size_t row = 0; row < height; ++row) {
    auto* const bytes = reinterpret_cast<std::uint8_t*>(copy.data() + row * width);
    std::memcpy(bytes, data + row * step, width * sizeof(Pixel));
    for (std::size_t i = 0; swapped && i < width; ++i) {
      std::reverse(bytes + i * sizeof(Pixel), bytes + (i + 1) * sizeof(Pixel));
    }
  }
  return {copy.data(), static_cast<int>(width), static_cast<int>(height),
          static_cast<std::ptrdiff_t>(width)};
}

ThermalImageReader::View ThermalImageReader::read(const sensor_msgs::msg::Image& message) {
  const std::string& encoding = message.encoding;
  if (encoding == "mono16" || encoding == "16UC1") {
    return view(message, counts_);
  }
  if (encoding == "32FC1") {
    return view(message, temperatures_);
  }
  if (encoding == "mono8" || encoding == "8UC1") {
    return view(message, grey_);
  }
  constexpr std::array kColours{"rgb", "bgr", "yuv", "bayer", "8UC3", "8UC4"};
  const bool colours =
      std::ranges::any_of(kColours, [&](const char* begin) { return encoding.starts_with(begin); });
  throw std::invalid_argument(
      "encoding is '" + encoding + "'" +
      (colours ? ", colours, from which no temperatures can be read" : "") +
      "; it must be 32FC1 (degC), mono16 or 16UC1 (counts), mono8 or 8UC1 (grey levels)");
}

}  // namespace pipescout
