// SPDX-License-Identifier: Apache-2.0
#include "rack_texture_map.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::simulation::internal {

TextureMap::TextureMap(int width, int height, std::span<const float> values) {
  std::vector<float> current(values.begin(), values.end());
  std::size_t level = 0;
  std::size_t total = 0;
  for (int w = width, h = height; w >= 1 && h >= 1; w /= 2, h /= 2) {
    total += static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  }
  texels_.reserve(total);
  while (true) {
    levels_[level] = {.width = width,
                      .height = height,
                      .shift = std::countr_zero(static_cast<unsigned>(width)),
                      .scale = std::ldexp(1.0F, -static_cast<int>(level)),
                      .begin = texels_.size()};
    for (const float value : current) {
      texels_.push_back(
          static_cast<std::uint16_t>(std::lround(65535.0F * std::clamp(value, 0.0F, 1.0F))));
    }
    if (width == 1 || height == 1 || level + 1 == kMostLevels) {
      break;
    }
    const int half_width = width / 2;
    const int half_height = height / 2;
    std::vector<float> next;
    next.reserve(static_cast<std::size_t>(half_width) * static_cast<std::size_t>(half_height));
    for (int j = 0; j < half_height; ++j) {
      const float* upper = current.data() + static_cast<std::ptrdiff_t>(2 * j) * width;
      const float* lower = upper + width;
      for (int i = 0; i < half_width; ++i) {
        next.push_back(0.25F * (upper[2 * i] + upper[2 * i + 1] + lower[2 * i] + lower[2 * i + 1]));
      }
    }
    current = std::move(next);
    width = half_width;
    height = half_height;
    ++level;
  }
  last_level_ = static_cast<float>(level);
}

}  // namespace pipescout::simulation::internal
