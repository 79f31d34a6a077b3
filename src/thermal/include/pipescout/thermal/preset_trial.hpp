// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pipescout/thermal/image.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace pipescout::thermal {

/// Which presets find pipes in images in which another one finds none. Keeps copies of a few of the
/// images, evenly spread. Not thread-safe.
class PresetTrial {
 public:
  /// Images that are kept at most: a trial takes a second or two, whatever the length of a
  /// recording.
  static constexpr std::size_t kMostImages = 16;

  /// The next image of a recording. Ignored if it has no pixels.
  void keep(const TemperatureView& image);
  /// Images that are kept.
  [[nodiscard]] std::size_t images() const noexcept { return kept_.size(); }

  struct Outcome {
    DetectorPreset preset = kDefaultPreset;
    std::size_t with_pipes = 0;  ///< of the images that are kept, at least 1
  };
  /// Of collectors, hot_pipes and cold_pipes without `used`: those that find pipes, in most images
  /// first.
  [[nodiscard]] std::vector<Outcome> try_others(DetectorPreset used) const;

  struct Range {
    double low = 0;
    double high = 0;
  };
  /// degC: all but the coldest and the hottest thousandth of the pixels that are kept. Nothing
  /// without a temperature.
  [[nodiscard]] std::optional<Range> temperatures() const;

 private:
  struct Kept {
    std::vector<float> degrees;
    int width = 0;
    int height = 0;
    [[nodiscard]] TemperatureView view() const noexcept {
      return {degrees.data(), width, height, width};
    }
  };
  std::vector<Kept> kept_;
  std::size_t seen_ = 0;
  std::size_t step_ = 1;  // of so many images one is kept
};

}  // namespace pipescout::thermal
