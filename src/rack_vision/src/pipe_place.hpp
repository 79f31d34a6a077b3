// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace pipescout::rack_vision {

/// An edge that was found near the contour of a pipe, as what it says if it is that contour.
struct PlaceVote {
  double offset = 0;         ///< of the pipe, m
  double half_width = 0;     ///< m: votes within it are for the same place
  std::uint32_t sample = 0;  ///< of the contour; it may have several votes, next to each other
};

/// The place that the votes of most samples agree on: their mean, m. None where it is that of less
/// than `least_share` of the samples, or where another one, farther than three half widths, has
/// nearly as many. Takes time by the square of the votes.
[[nodiscard]] std::optional<double> agreed_place(std::span<const PlaceVote> votes, int samples,
                                                 double least_share);

}  // namespace pipescout::rack_vision
