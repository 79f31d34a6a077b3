// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string_view>
#include <vector>

#include "pipescout/odometry_study/quantile.hpp"
#include "rack_figures.hpp"

namespace pipescout::reproduce {
namespace {

using Work = void (*)(RackReproduction&);

constexpr std::array<Work, kRackParts.size()> kWork{
    reproduce_rack_features, reproduce_rack_images, reproduce_rack_noise,   reproduce_rack_offsets,
    reproduce_rack_shapes,   reproduce_rack_bodies, reproduce_rack_cameras, reproduce_rack_leaks};

}  // namespace

double error_quantile(const std::vector<double>& errors, double part) {
  constexpr double kWithoutAny = 1;
  return errors.empty() ? kWithoutAny : odometry_study::quantile(errors, part);
}

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
  for (std::size_t i = 0; i < kWork.size(); ++i) {
    if (options.part.empty() || options.part == kRackParts[i]) {
      kWork[i](run);
    }
  }
  return result;
}

}  // namespace pipescout::reproduce
