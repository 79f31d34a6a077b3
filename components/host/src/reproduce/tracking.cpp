// SPDX-License-Identifier: Apache-2.0
#include "reproduce/arm.hpp"
#include "reproduce/figure_rows.hpp"
#include "reproduce/reproduce.hpp"
#include "reproduce/stage_progress.hpp"

namespace pipescout::host {

Reproduction reproduce_tracking(const ReproduceOptions& options, std::ostream& out) {
  Reproduction result;
  FigureRows rows(result, out);
  StageProgress progress(options);
  const std::vector<std::uint64_t> seeds = unseen_seeds(options.seeds);
  out << "Ibarguren and others: a pipe is kept in view. Seeds from " << seeds.front()
      << " on, which no tuning saw.\n\n";
  result.seeds = seeds;
  reproduce_arm({}, seeds, rows, progress);
  return result;
}

}  // namespace pipescout::host
