// SPDX-License-Identifier: Apache-2.0
#include "image_check.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace pipescout::rack_vision {
namespace {

// Of both functions: what one has fetched into the cache, the other finds there.
constexpr int kFirstRow = 4;
constexpr int kRowStep = 8;

}  // namespace

std::uint64_t fingerprint(const ImageView& image) noexcept {
  // Four independent chains, so that multiplications overlap.
  std::array<std::uint64_t, 4> lanes{0x9E3779B97F4A7C15U, 0xC2B2AE3D27D4EB4FU, 0x165667B19E3779F9U,
                                     0x27D4EB2F165667C5U};
  constexpr std::uint64_t kFactor = 0x100000001B3U;
  for (int v = std::min(kFirstRow, image.height - 1); v < image.height; v += kRowStep) {
    const std::uint8_t* row = image.row(v);
    int u = 0;
    for (; u + 32 <= image.width; u += 32) {
      for (std::size_t lane = 0; lane < lanes.size(); ++lane) {
        std::uint64_t word = 0;
        std::memcpy(&word, row + u + lane * sizeof(word), sizeof(word));
        lanes[lane] = (lanes[lane] ^ word) * kFactor;
        lanes[lane] ^= lanes[lane] >> 29U;
      }
    }
    for (; u < image.width; ++u) {
      lanes[0] = (lanes[0] ^ row[u]) * kFactor;
    }
  }
  std::uint64_t hash = 0;
  for (const std::uint64_t lane : lanes) {
    hash = (hash ^ lane) * kFactor;
    hash ^= hash >> 32U;
  }
  return hash;
}

int grey_range(const ImageView& image) noexcept {
  std::array<int, 256> histogram{};
  int count = 0;
  for (int v = kFirstRow; v < image.height; v += kRowStep) {
    const std::uint8_t* row = image.row(v);
    for (int u = 4; u < image.width; u += 8) {
      ++histogram[row[u]];
      ++count;
    }
  }
  const auto percentile = [&histogram](int below) {
    int level = 0;
    for (int sum = histogram[0]; level < 255 && sum <= below;) {
      ++level;
      sum += histogram[static_cast<std::size_t>(level)];
    }
    return level;
  };
  return percentile(count * 95 / 100) - percentile(count * 5 / 100);
}

}  // namespace pipescout::rack_vision
