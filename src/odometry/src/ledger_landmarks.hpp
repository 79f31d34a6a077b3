// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/odometry/weld_ledger.hpp"

namespace pipescout::odometry {

/// Lays the landmarks of a ledger along its welds again, from their sightings; without map
/// positions.
void place_landmarks(WeldLedger& ledger, const LedgerParameters& parameters);

}  // namespace pipescout::odometry
