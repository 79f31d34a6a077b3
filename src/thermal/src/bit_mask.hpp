// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pipescout::thermal {

/// One bit a pixel, 64 to a word, the lowest bit leftmost. Bits beyond the width are 0. Keeps its
/// memory.
class BitMask {
 public:
  void resize(int width, int height) {
    width_ = width;
    height_ = height;
    words_per_row_ = (static_cast<std::size_t>(width) + 63) / 64;
    words_.assign(words_per_row_ * static_cast<std::size_t>(height), 0);
  }
  [[nodiscard]] int width() const noexcept { return width_; }
  [[nodiscard]] int height() const noexcept { return height_; }
  [[nodiscard]] std::size_t words_per_row() const noexcept { return words_per_row_; }
  [[nodiscard]] std::uint64_t* row(int y) noexcept {
    return words_.data() + static_cast<std::size_t>(y) * words_per_row_;
  }
  [[nodiscard]] const std::uint64_t* row(int y) const noexcept {
    return words_.data() + static_cast<std::size_t>(y) * words_per_row_;
  }
  /// (x, y) must lie inside.
  [[nodiscard]] bool get(int x, int y) const noexcept {
    return ((row(y)[x >> 6] >> (x & 63)) & 1U) != 0;
  }
  [[nodiscard]] bool contains(int x, int y) const noexcept {
    return x >= 0 && y >= 0 && x < width_ && y < height_;
  }

 private:
  int width_ = 0;
  int height_ = 0;
  std::size_t words_per_row_ = 0;
  std::vector<std::uint64_t> words_;
};

}  // namespace pipescout::thermal
