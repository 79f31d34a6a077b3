// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "figures.hpp"

namespace pipescout::benchmarks {

/// Times one goal in one process, from sending it to its result.
void register_action_cases();

/// Races 10,000 goals in one process, and as many between two participants, each sent as soon as
/// the last one of its lane ended; cancellations race with the ends of a quarter of them (see
/// testing/action_race.hpp). Adds `actions_lost`, `actions_wrong`, and goals a second.
void add_action_figures(Figures& figures);

}  // namespace pipescout::benchmarks
