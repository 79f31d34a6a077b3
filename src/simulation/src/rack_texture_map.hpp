// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace pipescout::simulation::internal {

/// A picture of reflectances in [0, 1] that wraps around in both directions, with all its halvings,
/// so that a lookup can be as coarse as a pixel. Sizes are powers of two.
class TextureMap {
 public:
  TextureMap() = default;
  /// `values`: height * width, row-major; cut off at 0 and 1.
  TextureMap(int width, int height, std::span<const float> values);

  /// At column x and row y, texels (the middle of the first one is 0.5), averaged over
  /// 2^level texels or so; level >= 0. Trilinear.
  [[nodiscard]] float at(float x, float y, float level) const noexcept {
    const float capped = level < last_level_ ? level : last_level_;
    const int fine = static_cast<int>(capped);
    const float share = capped - static_cast<float>(fine);
    const float from_fine = bilinear(levels_[static_cast<std::size_t>(fine)], x, y);
    if (share < 0.02F) {
      return from_fine;
    }
    const float from_coarse = bilinear(levels_[static_cast<std::size_t>(fine) + 1], x, y);
    return from_fine + share * (from_coarse - from_fine);
  }

  [[nodiscard]] int width() const noexcept { return levels_[0].width; }
  [[nodiscard]] int height() const noexcept { return levels_[0].height; }

 private:
  struct Level {
    int width = 1;
    int height = 1;
    int shift = 0;    // width = 1 << shift
    float scale = 1;  // texels of this level per texel of the first
    std::size_t begin = 0;
  };

  [[nodiscard]] float bilinear(const Level& level, float x, float y) const noexcept {
    // Far on the positive side, so that the cast rounds down for places left of the origin too.
    constexpr float kPositive = 16384;
    const float column = x * level.scale - 0.5F + kPositive;
    const float row = y * level.scale - 0.5F + kPositive;
    const int i = static_cast<int>(column);
    const int j = static_cast<int>(row);
    const float fx = column - static_cast<float>(i);
    const float fy = row - static_cast<float>(j);
    const int i0 = i & (level.width - 1);
    const int i1 = (i + 1) & (level.width - 1);
    const std::uint16_t* data = texels_.data() + level.begin;
    const std::uint16_t* upper = data + ((j & (level.height - 1)) << level.shift);
    const std::uint16_t* lower = data + (((j + 1) & (level.height - 1)) << level.shift);
    const float a = static_cast<float>(upper[i0]);
    const float b = static_cast<float>(upper[i1]);
    const float c = static_cast<float>(lower[i0]);
    const float d = static_cast<float>(lower[i1]);
    const float top = a + fx * (b - a);
    const float bottom = c + fx * (d - c);
    return (top + fy * (bottom - top)) * (1.0F / 65535.0F);
  }

  static constexpr std::size_t kMostLevels = 16;
  std::array<Level, kMostLevels> levels_{};
  float last_level_ = 0;
  std::vector<std::uint16_t> texels_;
};

/// log2, continuous and right to 0.09: enough to choose a level. Positive, normal numbers.
[[nodiscard]] inline float rough_log2(float x) noexcept {
  return static_cast<float>(std::bit_cast<std::int32_t>(x)) * 0x1p-23F - 127.0F;
}

}  // namespace pipescout::simulation::internal
