// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout::rack_vision {

/// Places between the pixels of an image at which it is read, at most kMost.
template <std::size_t kMost>
class BilinearSamples {
 public:
  /// px; there must be a pixel to its right and one below.
  void add(float u, float v) noexcept {
    u_[count_] = u;
    v_[count_] = v;
    ++count_;
  }

  /// Grey levels in the order of the places, by bilinear interpolation. In passes: only the one
  /// that fetches pixels goes from place to place, the others are vectorised by the compiler.
  void read(const ImageView& image, std::array<float, kMost>& values) const noexcept {
    std::array<int, kMost> whole_u, whole_v;
    for (std::size_t i = 0; i < count_; ++i) {
      whole_u[i] = static_cast<int>(u_[i]);
      whole_v[i] = static_cast<int>(v_[i]);
    }
    std::array<std::array<std::uint8_t, 2>, kMost> upper, lower;
    for (std::size_t i = 0; i < count_; ++i) {
      const std::uint8_t* pixel = image.row(whole_v[i]) + whole_u[i];
      upper[i] = {pixel[0], pixel[1]};
      lower[i] = {pixel[image.stride], pixel[image.stride + 1]};
    }
    for (std::size_t i = 0; i < count_; ++i) {
      const float right = u_[i] - static_cast<float>(whole_u[i]);
      const float down = v_[i] - static_cast<float>(whole_v[i]);
      const auto a = static_cast<float>(upper[i][0]);
      const auto b = static_cast<float>(lower[i][0]);
      const float top = a + right * (static_cast<float>(upper[i][1]) - a);
      const float bottom = b + right * (static_cast<float>(lower[i][1]) - b);
      values[i] = top + down * (bottom - top);
    }
  }

 private:
  std::array<float, kMost> u_, v_;
  std::size_t count_ = 0;
};

}  // namespace pipescout::rack_vision
