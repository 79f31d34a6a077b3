// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout::rack_vision {

/// Hash of all pixels: equal for identical images, almost surely different for others.
[[nodiscard]] std::uint64_t fingerprint(const ImageView& image) noexcept;

/// Grey levels between the 5th and the 95th percentile of a sample of the pixels.
[[nodiscard]] int grey_range(const ImageView& image) noexcept;

}  // namespace pipescout::rack_vision
