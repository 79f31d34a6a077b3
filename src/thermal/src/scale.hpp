// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <span>
#include <type_traits>

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

}  // namespace pipescout::thermal
