// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "bit_mask.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::thermal {

/// Counts and what they mean; the same for pictures of temperatures, which need no table. NaN for
/// values that no body has.
template <class Pixel>
struct Scale {
  std::span<const float> celsius{};

  [[nodiscard]] float operator()(Pixel value) const noexcept {
    if constexpr (std::is_same_v<Pixel, float>) {
      const bool of_a_body =
          value > static_cast<float>(-kZeroCelsius) && value < static_cast<float>(kHottestBody);
      return of_a_body ? value : std::numeric_limits<float>::quiet_NaN();
    } else {
      return value < celsius.size() ? celsius[value] : std::numeric_limits<float>::quiet_NaN();
    }
  }
};

/// Which pixels a pipe may be at.
class ThresholdMask {
 public:
  /// Returns what is wrong with the picture or the table; then the mask is empty.
  template <class Pixel>
  FrameFault make(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                  const LeakDetectorParameters& parameters);

  [[nodiscard]] const BitMask& mask() const noexcept { return mask_; }
  /// degC, that was used; NaN when it differs from pixel to pixel, and when there was no contrast.
  [[nodiscard]] double threshold() const noexcept { return threshold_; }

 private:
  template <class Pixel>
  double scene_threshold(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                         const LeakDetectorParameters& parameters);
  template <class Pixel>
  void make_local(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                  const LeakDetectorParameters& parameters);

  BitMask mask_;
  double threshold_ = 0;
  std::vector<std::uint32_t> histogram_;
  std::vector<float> temperatures_;  // of the picture, NaN replaced
  std::vector<float> differences_;   // from the surroundings
  std::vector<double> column_sums_;
};

extern template FrameFault ThresholdMask::make(const TemperatureView&, const Scale<float>&,
                                               const LeakDetectorParameters&);
extern template FrameFault ThresholdMask::make(const CountView&, const Scale<std::uint16_t>&,
                                               const LeakDetectorParameters&);
extern template FrameFault ThresholdMask::make(const GreyView&, const Scale<std::uint8_t>&,
                                               const LeakDetectorParameters&);

}  // namespace pipescout::thermal
