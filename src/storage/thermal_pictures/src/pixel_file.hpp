// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <variant>
#include <vector>

namespace pipescout {

/// Bytes that are no picture of one channel; what() says why, without the file's name.
class PixelError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
/// Such a picture in colours.
class ColourError : public PixelError {
 public:
  using PixelError::PixelError;
};

template <class Pixel>
struct Pixels {
  int width = 0;
  int height = 0;
  std::vector<Pixel> values;  ///< row by row
};

using AnyPixels = std::variant<Pixels<std::uint8_t>, Pixels<std::uint16_t>, Pixels<float>>;

/// Takes a PNG, TIFF or JPEG apart. Three channels of 8 bits with the same values are one. Throws
/// PixelError, ColourError.
[[nodiscard]] AnyPixels decode_pixels(std::span<const std::uint8_t> bytes);

}  // namespace pipescout
