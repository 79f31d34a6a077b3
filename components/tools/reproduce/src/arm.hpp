// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "figure_rows.hpp"
#include "pipescout/arm_study/arm_drive.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {

/// Rows and figures of the arm in `pipescout reproduce tracking`: `in_view_percent`,
/// `arm_error_rms_px`, `arm_limit_violations`, `arm_safe_states`. One drive for each of the first
/// three seeds and each class of road, as many at once as there are processors. `all_seeds` is not
/// empty.
void reproduce_arm(const arm_study::DriveSettings& settings,
                   const std::vector<std::uint64_t>& all_seeds, FigureRows& rows,
                   StageProgress& progress);

}  // namespace pipescout::reproduce
