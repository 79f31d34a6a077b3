// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "threshold_mask.hpp"

namespace pipescout::thermal {

/// PipeSection::width. `pipe_shaped`: of each pixel along the axis of `pipe`, whether the pipe is
/// seen there as one.
template <class Pixel>
[[nodiscard]] double apparent_width(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                                    const PipeSection& pipe,
                                    std::span<const std::uint8_t> pipe_shaped, Polarity polarity);

extern template double apparent_width(const TemperatureView&, const Scale<float>&,
                                      const PipeSection&, std::span<const std::uint8_t>, Polarity);
extern template double apparent_width(const CountView&, const Scale<std::uint16_t>&,
                                      const PipeSection&, std::span<const std::uint8_t>, Polarity);
extern template double apparent_width(const GreyView&, const Scale<std::uint8_t>&,
                                      const PipeSection&, std::span<const std::uint8_t>, Polarity);

}  // namespace pipescout::thermal
