// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bit_mask.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "ridge.hpp"
#include "scale.hpp"

namespace pipescout::thermal {

/// Which pixels a pipe may be at.
class ThresholdMask {
 public:
  /// Returns what is wrong with the picture or the table; then the mask is empty.
  template <class Pixel>
  FrameFault make(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                  const LeakDetectorParameters& parameters, const FrameConditions& conditions);

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

  template <class Pixel>
  double contrast_threshold(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                            const LeakDetectorParameters& parameters,
                            const FrameConditions& conditions);

  BitMask mask_;
  RidgeFinder ridges_;
  double threshold_ = 0;
  std::vector<std::uint32_t> histogram_;
  std::vector<float> temperatures_;  // of the picture, NaN replaced
  std::vector<float> differences_;   // from the surroundings
  std::vector<double> column_sums_;
};

extern template FrameFault ThresholdMask::make(const TemperatureView&, const Scale<float>&,
                                               const LeakDetectorParameters&,
                                               const FrameConditions&);
extern template FrameFault ThresholdMask::make(const CountView&, const Scale<std::uint16_t>&,
                                               const LeakDetectorParameters&,
                                               const FrameConditions&);
extern template FrameFault ThresholdMask::make(const GreyView&, const Scale<std::uint8_t>&,
                                               const LeakDetectorParameters&,
                                               const FrameConditions&);

}  // namespace pipescout::thermal
