// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "figure_rows.hpp"
#include "reproduce.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {

/// `count` in all (one for each seed at least), the same number of each seed.
[[nodiscard]] std::vector<std::uint64_t> drawn_seeds(const std::vector<std::uint64_t>& seeds,
                                                     std::size_t count);

/// Missions and tours of inspection in a closed loop with a simulated vehicle.
void add_navigation_missions(const std::vector<std::uint64_t>& seeds,
                             const NavigationExtent& extent, FigureRows& rows,
                             StageProgress& progress);

}  // namespace pipescout::reproduce
