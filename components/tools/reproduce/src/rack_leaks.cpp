// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <vector>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/leak_study/rack_inspection.hpp"
#include "rack_figures.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using leak_study::RackInspectionScore;

double found_percent(const RackInspectionScore& score) {
  return percent(score.found, score.hot_spots);
}

}  // namespace

void reproduce_rack_leaks(RackReproduction& run) {
  const leak_study::RackInspectionSettings& settings = run.extent.leaks;
  const auto seeds =
      seeds_of(run.options, std::min(run.seeds.size(), run.extent.largest_leak_seeds));
  const std::string study = "Leaks over the rack: " + std::to_string(seeds.size()) +
                            " flights with " + std::to_string(settings.hot_spots) +
                            " hot spots each";
  const auto scores = for_each_seed(run.progress, study, seeds, [&](std::uint64_t seed) {
    return leak_study::inspect_rack(settings, seed);
  });
  const auto total = [&](auto count) { return static_cast<std::size_t>(sum(each(scores, count))); };
  std::vector<double> errors;
  for (const RackInspectionScore& score : scores) {
    errors.insert(errors.end(), score.position_errors.begin(), score.position_errors.end());
  }
  const std::size_t found = total(&RackInspectionScore::found);
  const auto false_findings = each(scores, &RackInspectionScore::false_findings);
  const auto p95 = [](const RackInspectionScore& score) {
    return error_quantile(score.position_errors, 0.95);
  };
  run.rows.add_study(
      study,
      {{"hot spots found, %", percent(found, total(&RackInspectionScore::hot_spots)),
        each(scores, found_percent), at_least(95), "rack_leaks_found_percent"},
       {"findings without a hot spot, and duplicates", sum(false_findings), false_findings, kNone,
        "rack_leaks_false"},
       {"position error of a hot spot, 95 %, m", error_quantile(errors, 0.95), each(scores, p95),
        at_most(0.10), "rack_leaks_position_p95_m"},
       {"truth inside the 95 % ellipsoid of the position, %",
        percent(total(&RackInspectionScore::covered), found),
        each(scores,
             [](const RackInspectionScore& score) { return percent(score.covered, score.found); }),
        kLargeIsGood},
       {"images with a pose, %",
        percent(total(&RackInspectionScore::with_pose), total(&RackInspectionScore::images)),
        each(scores,
             [](const RackInspectionScore& score) {
               return percent(score.with_pose, score.images);
             }),
        kLargeIsGood},
       {"thermal images placed by the state estimator, %",
        percent(total(&RackInspectionScore::placed), total(&RackInspectionScore::thermal_images)),
        each(scores,
             [](const RackInspectionScore& score) {
               return percent(score.placed, score.thermal_images);
             }),
        kLargeIsGood},
       {"flights that reached all way-points, of " + std::to_string(scores.size()),
        static_cast<double>(total(&RackInspectionScore::complete)),
        each(scores, &RackInspectionScore::complete), kLargeIsGood}});
}

}  // namespace pipescout::reproduce
