// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/grey_image.hpp"

#include <array>
#include <stdexcept>
#include <string>

#include "image_shape.hpp"

namespace pipescout {
namespace {

struct Encoding {
  const char* name;
  std::size_t channels;
  std::size_t red;  ///< place of red; blue is at 2 - red
};

constexpr std::array kEncodings{
    Encoding{"mono8", 1, 0}, Encoding{"8UC1", 1, 0}, Encoding{"rgb8", 3, 0},
    Encoding{"bgr8", 3, 2},  Encoding{"8UC3", 3, 2}, Encoding{"rgba8", 4, 0},
    Encoding{"bgra8", 4, 2}, Encoding{"8UC4", 4, 2},
};

/// Weights of ITU-R BT.601 in 1/256.
constexpr unsigned kRed = 77;
constexpr unsigned kGreen = 150;
constexpr unsigned kBlue = 29;

const Encoding& encoding_of(const std::string& name) {
  for (const Encoding& encoding : kEncodings) {
    if (name == encoding.name) {
      return encoding;
    }
  }
  throw std::invalid_argument("encoding is '" + name +
                              "'; it must be mono8, rgb8, bgr8, rgba8 or bgra8");
}

}  // namespace

rack_vision::ImageView GreyImageReader::read(const sensor_msgs::msg::Image& message) {
  const Encoding& encoding = encoding_of(message.encoding);
  const std::size_t width = message.width;
  const std::size_t height = message.height;
  const std::size_t step = message.step;
  require_shape(message, encoding.channels);
  const std::uint8_t* const data = message.data.data();
  if (encoding.channels == 1) {
    return {data, static_cast<int>(width), static_cast<int>(height), static_cast<int>(step)};
  }
  grey_.resize(width * height);
  for (std::size_t row = 0; row < height; ++row) {
    const std::uint8_t* pixel = data + row * step;
    std::uint8_t* const grey = grey_.data() + row * width;
    for (std::size_t column = 0; column < width; ++column, pixel += encoding.channels) {
      grey[column] = static_cast<std::uint8_t>((kRed * pixel[encoding.red] + kGreen * pixel[1] +
                                                kBlue * pixel[2 - encoding.red] + 128U) >>
                                               8U);
    }
  }
  return {grey_.data(), static_cast<int>(width), static_cast<int>(height), static_cast<int>(width)};
}

}  // namespace pipescout
