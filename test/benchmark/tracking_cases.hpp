// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "figures.hpp"

/// What the particle filter and the tracker cost: part of the tracking program.
namespace pipescout::benchmarks {

/// Registers the cases: a pipe and four other regions, 100 to 100,000 particles, and the peer.
void register_tracker_cases();
/// `update_1000_us`, `update_100000_over_linear`, `speedup_vs_peer`, `allocations_after_warm_up`
/// and others, with their rows.
void add_tracker_figures(Figures& figures);

}  // namespace pipescout::benchmarks
