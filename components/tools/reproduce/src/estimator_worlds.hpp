// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "figure_rows.hpp"
#include "reproduce.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {

/// Each robot in worlds that differ from what it is told: `world_...`.
void reproduce_worlds(const ReproduceOptions& options, const EstimatorExtent& extent,
                      FigureRows& rows, StageProgress& progress);

}  // namespace pipescout::reproduce
