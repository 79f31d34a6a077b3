// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
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

  /// The same for `count` places: at `middle` + i `step` + `beside`, i from `first` on.
  void add_line(const Eigen::Vector2d& middle, const Eigen::Vector2d& step,
                const Eigen::Vector2d& beside, int first, int count) noexcept {
    const double middle_u = middle.x(), middle_v = middle.y();
    const double step_u = step.x(), step_v = step.y();
    const double beside_u = beside.x(), beside_v = beside.y();
    float* u = u_.data() + count_;
    float* v = v_.data() + count_;
    for (int i = 0; i < count; ++i) {
      u[i] = static_cast<float>(middle_u + (first + i) * step_u + beside_u);
      v[i] = static_cast<float>(middle_v + (first + i) * step_v + beside_v);
    }
    count_ += static_cast<std::size_t>(count);
  }

  /// Grey levels in the order of the places, by bilinear interpolation. In passes: only the one
  /// that fetches pixels goes from place to place, the others are vectorised by the compiler.
  void read(const ImageView& image, std::array<float, kMost>& values) const noexcept {
    std::array<int, kMost> whole_u, whole_v;
    for (std::size_t i = 0; i < count_; ++i) {
      whole_u[i] = static_cast<int>(u_[i]);
      whole_v[i] = static_cast<int>(v_[i]);
    }
    std::array<std::uint32_t, kMost> pixels;  // of a place: a byte for each
    const auto pair = [](const std::uint8_t* left) -> std::uint32_t {
      return left[0] | static_cast<std::uint32_t>(left[1]) << 8U;
    };
    for (std::size_t i = 0; i < count_; ++i) {
      const std::uint8_t* upper = image.row(whole_v[i]) + whole_u[i];
      pixels[i] = pair(upper) | pair(upper + image.stride) << 16U;
    }
    // By way of a signed number: that is one instruction.
    const auto level = [](std::uint32_t four, unsigned bit) {
      return static_cast<float>(static_cast<int>(four >> bit & 0xFFU));
    };
    for (std::size_t i = 0; i < count_; ++i) {
      const float right = u_[i] - static_cast<float>(whole_u[i]);
      const float down = v_[i] - static_cast<float>(whole_v[i]);
      const float a = level(pixels[i], 0);
      const float b = level(pixels[i], 16);
      const float top = a + right * (level(pixels[i], 8) - a);
      const float bottom = b + right * (level(pixels[i], 24) - b);
      values[i] = top + down * (bottom - top);
    }
  }

 private:
  std::array<float, kMost> u_, v_;
  std::size_t count_ = 0;
};

}  // namespace pipescout::rack_vision
