// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/odometry/weld_ledger.hpp"

namespace pipescout::odometry {

/// Sets chainages, joint lengths and their standard deviations from the sightings, and sorts the
/// welds. See `merge_run`. The chainages on entry are where the search begins.
void adjust(WeldLedger& ledger, const LedgerParameters& parameters);

}  // namespace pipescout::odometry
