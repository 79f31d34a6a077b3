// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "figures.hpp"

namespace pipescout::benchmarks {

/// 10,000 goals of an action in one process, and 10,000 between two processes' worth of contexts
/// over DDS, each sent as soon as the last one ended; cancellations race with the ends of a quarter
/// of them. Adds `actions_lost`, `actions_wrong` (both over all goals) and the goals a second.
void add_action_figures(Figures& figures);

}  // namespace pipescout::benchmarks
