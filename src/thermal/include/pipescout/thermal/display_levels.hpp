// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "pipescout/thermal/image.hpp"

namespace pipescout::thermal {

/// Grey levels for people to look at, row by row: black for the coldest hundredth of the pixels,
/// white for the hottest thousandth, so that single pixels do not darken the others; black without
/// a finite value, too. Throws std::invalid_argument for a view that is not valid. Of
/// TemperatureView, CountView and GreyView.
template <class Pixel>
[[nodiscard]] std::vector<std::uint8_t> display_levels(const ImageView<Pixel>& image);

extern template std::vector<std::uint8_t> display_levels(const TemperatureView& image);
extern template std::vector<std::uint8_t> display_levels(const CountView& image);
extern template std::vector<std::uint8_t> display_levels(const GreyView& image);

}  // namespace pipescout::thermal
