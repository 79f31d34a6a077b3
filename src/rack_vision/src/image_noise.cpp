// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/image_noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>

namespace pipescout::rack_vision {
namespace {

constexpr int kWide = 16;  // responses of a block
constexpr int kHigh = 4;
constexpr int kBlockWidth = kWide + 2;  // px
constexpr int kBlockHeight = kHigh + 2;
constexpr int kMostBlocks = 2000;
constexpr int kFewestBlocks = 16;  // of a range of grey levels, for it to have a value of its own
constexpr double kLevelWidth = 256.0 / static_cast<double>(ImageNoise::kLevels);
// Of the blocks of a range, those with texture or an edge are the others. The quantile of pure
// noise is below its mean by this factor, measured.
constexpr double kQuantile = 0.2;
constexpr double kQuantileOfMean = 0.92;
// A range of which every block has texture is no noisier than this times the whole image.
constexpr double kMostOfAll = 2.0;
constexpr double kStep = 0.2;  // grey levels, of the histograms
constexpr std::size_t kSteps = 256;

using Histogram = std::array<std::uint16_t, kSteps>;

struct Block {
  double level = 0;
  double sigma = 0;
  bool clipped = false;
};

Block look_at(const ImageView& image, int u, int v) noexcept {
  std::int32_t sum = 0;
  std::int32_t responses = 0;
  std::uint8_t lowest = 255;
  std::uint8_t highest = 0;
  for (int j = 0; j < kHigh; ++j) {
    const std::uint8_t* above = image.row(v + j) + u;
    const std::uint8_t* here = image.row(v + j + 1) + u;
    const std::uint8_t* below = image.row(v + j + 2) + u;
    std::array<std::int16_t, kBlockWidth> down;
    for (std::size_t i = 0; i < kBlockWidth; ++i) {
      down[i] = static_cast<std::int16_t>(above[i] - 2 * here[i] + below[i]);
      sum += here[i];
      lowest = std::min(lowest, here[i]);
      highest = std::max(highest, here[i]);
    }
    for (std::size_t i = 0; i < kWide; ++i) {
      responses += std::abs(down[i] - 2 * down[i + 1] + down[i + 2]);
    }
  }
  // The squares of the weights add up to 36; a normal deviate is sqrt(2 / pi) on average.
  const double per_response = std::sqrt(std::numbers::pi / 2) / 6;
  return {.level = static_cast<double>(sum) / (kHigh * kBlockWidth),
          .sigma = per_response * responses / (kHigh * kWide),
          // What is cut off at black or white has lost its noise.
          .clipped = lowest == 0 || highest == 255};
}

std::size_t range_of(double level) noexcept {
  return std::min(ImageNoise::kLevels - 1,
                  static_cast<std::size_t>(std::max(0.0, level) / kLevelWidth));
}

/// The quantile of a histogram of `count` values, as the mean of pure noise has it.
double noise_of(const Histogram& histogram, int count) noexcept {
  const double wanted = kQuantile * count;
  double below = 0;
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double here = histogram[i];
    if (below + here >= wanted && here > 0) {
      const double part = (wanted - below) / here;
      return kStep * (static_cast<double>(i) + part) / kQuantileOfMean;
    }
    below += here;
  }
  return 0;
}

}  // namespace

void ImageNoise::measure(const ImageView& image) noexcept {
  sigma_.fill(0);
  if (!image.valid() || image.width < kBlockWidth || image.height < kBlockHeight) {
    return;
  }
  std::array<Histogram, kLevels> histograms{};
  std::array<int, kLevels> counts{};
  Histogram all{};
  int count = 0;
  const double pixels = static_cast<double>(image.width) * image.height;
  const int step_u = std::max(kBlockWidth, static_cast<int>(std::sqrt(3 * pixels / kMostBlocks)));
  const int step_v = std::max(kBlockHeight, step_u / 3);
  for (int v = 0; v + kBlockHeight <= image.height; v += step_v) {
    for (int u = 0; u + kBlockWidth <= image.width; u += step_u) {
      const Block block = look_at(image, u, v);
      if (block.clipped) {
        continue;
      }
      const auto step = std::min(kSteps - 1, static_cast<std::size_t>(block.sigma / kStep));
      const std::size_t range = range_of(block.level);
      ++histograms[range][step];
      ++counts[range];
      ++all[step];
      ++count;
    }
  }
  const double overall = noise_of(all, count);
  for (std::size_t i = 0; i < kLevels; ++i) {
    if (counts[i] >= kFewestBlocks) {
      sigma_[i] = std::min(noise_of(histograms[i], counts[i]), kMostOfAll * overall);
    }
  }
  // Ranges with few pixels are like the nearest one that has enough.
  for (std::size_t i = 0; i < kLevels; ++i) {
    if (counts[i] >= kFewestBlocks) {
      continue;
    }
    sigma_[i] = overall;
    for (std::size_t away = 1; away < kLevels; ++away) {
      const bool lower = i >= away && counts[i - away] >= kFewestBlocks;
      const bool upper = i + away < kLevels && counts[i + away] >= kFewestBlocks;
      if (lower || upper) {
        sigma_[i] = lower ? sigma_[i - away] : sigma_[i + away];
        break;
      }
    }
  }
}

double ImageNoise::sigma(double level) const noexcept {
  const double at = std::clamp(level / kLevelWidth - 0.5, 0.0, static_cast<double>(kLevels - 1));
  const auto low = std::min(static_cast<std::size_t>(at), kLevels - 2);
  const double part = at - static_cast<double>(low);
  return (1 - part) * sigma_[low] + part * sigma_[low + 1];
}

double ImageNoise::excess(double level) const noexcept {
  constexpr double kAllFrom = 1.5;  // times kNominalNoise
  constexpr double kSlope = kAllFrom * kAllFrom / (kAllFrom * kAllFrom - 1);
  const double variance = sigma(level) * sigma(level);
  return std::sqrt(std::clamp(kSlope * (variance - kNominalNoise * kNominalNoise), 0.0, variance));
}

double ImageNoise::texture_contrast(double least, double level) const noexcept {
  return std::max(least, 2 * excess(level));
}

}  // namespace pipescout::rack_vision
