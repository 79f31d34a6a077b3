// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "figures.hpp"

/// What a cycle of the camera arm's controller costs: part of the tracking program.
namespace pipescout::benchmarks {

/// Registers the cases: 100 Hz on a vehicle that rolls, joint readings and odometry each cycle, a
/// track each fourth; tracking, and close to the hull, where the way to rest is checked.
void register_arm_cases();
/// `arm_cycle_us`, the larger median of both, at most 50; `arm_cycle_p99_us`; and
/// `arm_allocations`, after warm-up, 0. With their rows.
void add_arm_figures(Figures& figures);

}  // namespace pipescout::benchmarks
