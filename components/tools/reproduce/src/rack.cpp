// SPDX-License-Identifier: Apache-2.0
#include "rack_figures.hpp"

namespace pipescout::reproduce {

Reproduction reproduce_rack(const ReproduceOptions& options, std::ostream& out) {
  return reproduce_rack(options, RackExtent{}, out);
}

Reproduction reproduce_rack(const ReproduceOptions& options, const RackExtent& extent,
                            std::ostream& out) {
  Reproduction result;
  FigureRows rows(result, out);
  StageProgress progress(options);
  RackReproduction run{.options = options,
                       .extent = extent,
                       .out = out,
                       .result = result,
                       .rows = rows,
                       .progress = progress,
                       .seeds = seeds_of(options, options.seeds)};
  out << "Lippiello and Cacace: a UAV over a pipe rack. Seeds " << run.seeds.front() << " to "
      << run.seeds.back() << ", not used for tuning.\n\n";
  result.seeds = run.seeds;
  reproduce_rack_features(run);
  if (extent.images.largest_seeds > 0) {
    reproduce_rack_images(run);
  }
  reproduce_rack_leaks(run);
  return result;
}

}  // namespace pipescout::reproduce
