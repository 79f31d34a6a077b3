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
constexpr int kBlocksOfStrip = 4;  // with common borders
constexpr int kMostStrips = 250;
constexpr int kFewestBlocks = 16;  // of a range of grey levels, for it to have a value of its own
constexpr std::uint8_t kWhite = 255;
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

/// Blocks beside each other, one value per response of a row. In loops of this length the compiler
/// keeps to as few bits as they need.
template <typename Value>
using Columns = std::array<Value, kBlocksOfStrip * kWide>;

class Strip {
 public:
  /// With so many columns of responses; u, v: their first pixel's neighbour above and to the left.
  Strip(const ImageView& image, int u, int v, std::size_t columns) noexcept {
    std::array<Columns<std::int16_t>, kBlockHeight> across;
    for (int j = 0; j < kBlockHeight; ++j) {
      const std::uint8_t* pixels = image.row(v + j) + u;
      std::int16_t* row = across[static_cast<std::size_t>(j)].data();
      for (std::size_t i = 0; i < columns; ++i) {
        row[i] = static_cast<std::int16_t>(pixels[i] - 2 * pixels[i + 1] + pixels[i + 2]);
      }
    }
    for (std::size_t j = 0; j < kHigh; ++j) {
      const std::uint8_t* pixels = image.row(v + static_cast<int>(j) + 1) + u + 1;
      for (std::size_t i = 0; i < columns; ++i) {
        const auto response =
            static_cast<std::int16_t>(across[j][i] - 2 * across[j + 1][i] + across[j + 2][i]);
        responses_[i] = static_cast<std::int16_t>(responses_[i] + std::abs(response));
        levels_[i] = static_cast<std::uint16_t>(levels_[i] + pixels[i]);
        const auto below = static_cast<std::uint8_t>(pixels[i] - 1);
        highest_below_[i] = below > highest_below_[i] ? below : highest_below_[i];
      }
    }
  }

  [[nodiscard]] Block block(std::size_t index) const noexcept {
    std::int32_t response = 0;
    std::int32_t level = 0;
    std::uint8_t highest_below = 0;
    for (std::size_t i = index * kWide; i < (index + 1) * kWide; ++i) {
      response += responses_[i];
      level += levels_[i];
      highest_below = std::max(highest_below, highest_below_[i]);
    }
    constexpr int kResponses = kHigh * kWide;
    // The squares of the weights add up to 36; a normal deviate is sqrt(2 / pi) on average.
    const double per_response = std::sqrt(std::numbers::pi / 2) / 6;
    return {.level = static_cast<double>(level) / kResponses,
            .sigma = per_response * response / kResponses,
            // What is cut off at black or white has lost its noise.
            .clipped = highest_below >= kWhite - 1};
  }

 private:
  // Sums over the rows.
  Columns<std::int16_t> responses_{};
  Columns<std::uint16_t> levels_{};
  /// The highest of the levels less one: white is kWhite - 1 then, and black is above it.
  Columns<std::uint8_t> highest_below_{};
};

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
  // Flat cells: the rows between the strips are not fetched into the cache.
  const int step_u =
      std::max(kBlocksOfStrip * kWide, static_cast<int>(std::sqrt(3 * pixels / kMostStrips)));
  const int step_v = std::max(kBlockHeight, static_cast<int>(pixels / kMostStrips) / step_u);
  for (int v = 0; v + kBlockHeight <= image.height; v += step_v) {
    for (int u = 0; u + kBlockWidth <= image.width; u += step_u) {
      const int blocks = std::min(kBlocksOfStrip, (image.width - u - 2) / kWide);
      const Strip strip(image, u, v, static_cast<std::size_t>(blocks * kWide));
      for (int i = 0; i < blocks; ++i) {
        const Block block = strip.block(static_cast<std::size_t>(i));
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
