// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "figure_rows.hpp"
#include "reproduce.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {

/// Rows and figures of the leak inspection with the camera fixed to the robot and with it on the
/// arm that follows the tracker, along the same rows over the same ground:
/// `leaks_found_percent_fixed`, `leaks_found_percent_arm`, `leaks_missed_fixed`,
/// `leaks_missed_arm`, `tube_seen_percent_fixed`, `tube_seen_percent_arm`, `false_findings_fixed`,
/// `false_findings_arm`. One campaign for each of the first seeds. `all_seeds` is not empty.
void reproduce_arm_inspection(const TrackingExtent& extent,
                              const std::vector<std::uint64_t>& all_seeds, FigureRows& rows,
                              StageProgress& progress);

}  // namespace pipescout::reproduce
