// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/preset_trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

#include "pipescout/statistics/quantile.hpp"

namespace pipescout::thermal {
namespace {

/// Of the pixels, at either end: what a few defects have is no temperature of the scene.
constexpr double kTail = 1e-3;
/// Those that look for pipes by other temperatures. Torresol has the threshold of collectors;
/// contrast is for images without degrees.
constexpr std::array kTried{DetectorPreset::kCollectors, DetectorPreset::kHotPipes,
                            DetectorPreset::kColdPipes};

}  // namespace

void PresetTrial::keep(const TemperatureView& image) {
  if (!image.valid()) {
    return;
  }
  if (seen_++ % step_ != 0) {
    return;
  }
  if (kept_.size() == kMostImages) {
    // Every second one goes, which are those that twice the step would have passed over.
    std::size_t number = 0;
    std::erase_if(kept_, [&number](const Kept&) { return number++ % 2 == 1; });
    step_ *= 2;
    if ((seen_ - 1) % step_ != 0) {
      return;
    }
  }
  Kept copy{.degrees = {}, .width = image.width, .height = image.height};
  copy.degrees.reserve(static_cast<std::size_t>(image.width) *
                       static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    copy.degrees.insert(copy.degrees.end(), image.row(y), image.row(y) + image.width);
  }
  kept_.push_back(std::move(copy));
}

std::vector<PresetTrial::Outcome> PresetTrial::try_others(DetectorPreset used) const {
  std::vector<Outcome> outcomes;
  for (const DetectorPreset preset : kTried) {
    if (preset == used) {
      continue;
    }
    LeakDetector detector(LeakDetectorParameters::of(preset));
    const auto found = std::ranges::count_if(
        kept_, [&](const Kept& image) { return !detector.detect(image.view()).pipes.empty(); });
    if (found > 0) {
      outcomes.push_back({preset, static_cast<std::size_t>(found)});
    }
  }
  std::ranges::stable_sort(outcomes, std::ranges::greater{}, &Outcome::with_pipes);
  return outcomes;
}

std::optional<PresetTrial::Range> PresetTrial::temperatures() const {
  std::vector<float> known;
  for (const Kept& image : kept_) {
    std::ranges::copy_if(image.degrees, std::back_inserter(known),
                         [](float degrees) { return std::isfinite(degrees); });
  }
  if (known.empty()) {
    return std::nullopt;
  }
  const auto low = static_cast<double>(statistics::quantile_in_place(known, kTail));
  const auto high = static_cast<double>(statistics::quantile_in_place(known, 1 - kTail));
  return Range{low, high};
}

}  // namespace pipescout::thermal
