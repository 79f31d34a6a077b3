// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/rack_vision/image_view.hpp"

namespace pipescout::rack_vision {

inline constexpr int kLargestCell = 120;  ///< px

/// The best corner (Shi and Tomasi: largest smaller eigenvalue of the gradient matrix, 7 x 7) with
/// its middle in the square of `side` px at `low`, when that eigenvalue, a mean over the window, is
/// above `least` (grey levels per px, squared). The square must be at least 4 px within the image.
[[nodiscard]] std::optional<Eigen::Vector2i> strongest_corner(const ImageView& image,
                                                              const Eigen::Vector2i& low, int side,
                                                              float least) noexcept;

}  // namespace pipescout::rack_vision
