// SPDX-License-Identifier: Apache-2.0
#include "core/image_shrink.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace pipescout::host {
namespace {

struct Encoding {
  std::string_view name;
  std::size_t channels;
  std::size_t bytes;  ///< of a channel
};
constexpr std::array<Encoding, 6> kEncodings{{{"mono8", 1, 1},
                                              {"mono16", 1, 2},
                                              {"rgb8", 3, 1},
                                              {"bgr8", 3, 1},
                                              {"rgba8", 4, 1},
                                              {"bgra8", 4, 1}}};

std::uint64_t sample(const std::uint8_t* at, const Encoding& encoding, bool is_big_endian) {
  if (encoding.bytes == 1) {
    return at[0];
  }
  return is_big_endian ? std::uint64_t{at[0]} << 8U | at[1] : std::uint64_t{at[1]} << 8U | at[0];
}

void put(std::uint8_t* at, std::uint64_t value, const Encoding& encoding, bool is_big_endian) {
  if (encoding.bytes == 1) {
    at[0] = static_cast<std::uint8_t>(value);
    return;
  }
  at[is_big_endian ? 0 : 1] = static_cast<std::uint8_t>(value >> 8U);
  at[is_big_endian ? 1 : 0] = static_cast<std::uint8_t>(value);
}

}  // namespace

std::optional<sensor_msgs::msg::Image> shrink(const sensor_msgs::msg::Image& image, int factor) {
  const Encoding* encoding = nullptr;
  for (const auto& each : kEncodings) {
    if (image.encoding == each.name) {
      encoding = &each;
    }
  }
  const auto block = static_cast<std::size_t>(factor);
  if (encoding == nullptr || image.width < block || image.height < block) {
    return std::nullopt;
  }
  const std::size_t pixel = encoding->channels * encoding->bytes;
  if (image.step < image.width * pixel ||
      image.data.size() < std::size_t{image.step} * image.height) {
    return std::nullopt;
  }
  const bool is_big_endian = image.is_bigendian != 0;
  sensor_msgs::msg::Image result;
  result.header = image.header;
  result.encoding = image.encoding;
  result.is_bigendian = image.is_bigendian;
  result.width = static_cast<std::uint32_t>(image.width / block);
  result.height = static_cast<std::uint32_t>(image.height / block);
  result.step = static_cast<std::uint32_t>(result.width * pixel);
  result.data.resize(std::size_t{result.step} * result.height);
  for (std::size_t row = 0; row < result.height; ++row) {
    for (std::size_t value = 0; value < result.width * encoding->channels; ++value) {
      const std::size_t column = value / encoding->channels;
      const std::size_t channel = value % encoding->channels;
      std::uint64_t sum = 0;
      for (std::size_t y = row * block; y < (row + 1) * block; ++y) {
        for (std::size_t x = column * block; x < (column + 1) * block; ++x) {
          sum += sample(&image.data[y * image.step + x * pixel + channel * encoding->bytes],
                        *encoding, is_big_endian);
        }
      }
      put(&result.data[row * result.step + column * pixel + channel * encoding->bytes],
          (sum + block * block / 2) / (block * block), *encoding, is_big_endian);
    }
  }
  return result;
}

}  // namespace pipescout::host
