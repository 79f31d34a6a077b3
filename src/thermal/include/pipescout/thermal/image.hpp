// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace pipescout::thermal {

/// Non-owning view of an image, row by row from the upper left pixel. (0, 0) is the middle of that
/// pixel; x to the right, y down.
template <class Pixel>
struct ImageView {
  const Pixel* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;  ///< pixels from one row to the next, >= width

  [[nodiscard]] const Pixel* row(int y) const noexcept { return data + y * stride; }
  [[nodiscard]] Pixel operator()(int x, int y) const noexcept { return row(y)[x]; }
  /// Whether the view has pixels and rows do not overlap.
  [[nodiscard]] bool valid() const noexcept {
    return data != nullptr && width > 0 && height > 0 && stride >= width;
  }
};

using TemperatureView = ImageView<float>;    ///< degC; NaN where unknown
using CountView = ImageView<std::uint16_t>;  ///< of a camera, or scaled temperatures
using GreyView = ImageView<std::uint8_t>;    ///< grey levels of a known range

}  // namespace pipescout::thermal
