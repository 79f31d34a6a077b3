// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout::rack_vision {

/// Hash of every eighth row, which shows images that repeat one bit by bit: those of a live camera
/// differ in every row, if only by their noise. The other rows need not be fetched into the cache.
[[nodiscard]] std::uint64_t fingerprint(const ImageView& image) noexcept;

/// Grey levels between the 5th and the 95th percentile of a sample of the pixels.
[[nodiscard]] int grey_range(const ImageView& image) noexcept;

}  // namespace pipescout::rack_vision
