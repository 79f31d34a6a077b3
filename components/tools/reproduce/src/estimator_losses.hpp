// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "figure_rows.hpp"
#include "reproduce.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {

/// Each robot with 1, 10 and 30 % of the readings of each sensor lost, singly and in bursts, and
/// with each sensor half a second behind the others: `loss_...`.
void reproduce_losses(const ReproduceOptions& options, const EstimatorExtent& extent,
                      FigureRows& rows, StageProgress& progress);

}  // namespace pipescout::reproduce
