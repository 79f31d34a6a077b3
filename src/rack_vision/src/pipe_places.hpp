// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::rack_vision {

/// A place at which a pipe may lie.
struct PipePlace {
  double offset = 0;  ///< m, see PipeOffsets
  double score = 0;   ///< log-likelihood, with that of the offset in it
};

/// One place of every pipe.
struct PlacedPipes {
  std::array<double, kMaxPipes> offsets{};
  double score = 0;
};

/// Joint data association: up to `most` combinations of one place a pipe, the best first, in which
/// no pipe changes sides with a parallel one and none intersects another one by more than
/// `tolerance`, m. `places` has an entry per pipe; one without places stays at offset 0 and is in
/// nobody's way. Searched by a beam: of many bad combinations a few may be missed.
void place_pipes(const RackModel& model, std::span<const std::vector<PipePlace>> places,
                 double tolerance, std::size_t most, std::vector<PlacedPipes>& placed);

}  // namespace pipescout::rack_vision
