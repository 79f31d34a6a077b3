// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace pipescout::rack_vision {

/// Non-owning view of a grey image, 8 bits per pixel, row by row from the top. Cheap to copy; valid
/// as long as the pixels are.
struct ImageView {
  const std::uint8_t* pixels = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;  ///< bytes from one row to the next, at least `width`

  [[nodiscard]] const std::uint8_t* row(int v) const noexcept {
    return pixels + static_cast<std::ptrdiff_t>(v) * stride;
  }
  /// Whether the view has pixels, and rows do not overlap.
  [[nodiscard]] bool valid() const noexcept {
    return pixels != nullptr && width > 0 && height > 0 && stride >= width;
  }
};

}  // namespace pipescout::rack_vision
