// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/paper_flight.hpp"
#include "pipescout/rack_study/shaped_pipes.hpp"
#include "rack_figures.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using rack_study::ShapedPipesScore;
using rack_study::World;

/// Of one flight or several, with the file that states the deviations and with the one that does
/// not.
struct ToldAndNot {
  ShapedPipesScore told, not_told;
};

ToldAndNot fly_over_shapes(World world, double duration, std::uint64_t seed) {
  rack_study::ShapedPipesSettings settings;
  settings.rack = seed % 2 == 0 ? rack_study::rack_on_beams() : rack_study::parallel_rack(4);
  settings.world = world;
  settings.duration = duration;
  const auto pair = rack_study::compare_shaped_pipes(settings, seed);
  return {.told = rack_study::score_shaped_pipes({&pair.told, 1}),
          .not_told = rack_study::score_shaped_pipes({&pair.not_told, 1})};
}

/// What the file that states its deviations must do; the other one is only compared with.
std::vector<Measure> measures_of(const std::vector<ShapedPipesScore>& scores, bool told,
                                 const std::string& name) {
  ShapedPipesScore all;
  for (const ShapedPipesScore& score : scores) {
    all += score;
  }
  const auto of_errors = [](double part) {
    constexpr double kMillimetres = 1000;
    return [part](const ShapedPipesScore& score) {
      return kMillimetres * error_quantile(score.images.position_errors, part);
    };
  };
  const auto coverage = [](const ShapedPipesScore& score) {
    return percent(score.images.pose_covered_99, score.images.with_pose);
  };
  const auto median = of_errors(0.5);
  const auto p95 = of_errors(0.95);
  const auto found = [](const ShapedPipesScore& score) {
    return percent(score.shapes_found, score.shapes);
  };
  const auto values = [](const ShapedPipesScore& score) {
    return percent(score.values_covered, score.values);
  };
  const std::string suffix = told ? ", stated" : ", not stated";
  std::vector<Measure> measures = {
      {"position error, median, mm" + suffix, median(all), each(scores, median), kSmallIsGood,
       name + "position_median_mm"},
      {"position error, 95 %, mm" + suffix, p95(all), each(scores, p95), kSmallIsGood,
       name + "position_p95_mm"},
      {"images with a pose, %" + suffix, all.images.with_pose_percent(),
       each(scores, [](const auto& score) { return score.images.with_pose_percent(); }),
       kLargeIsGood, name + "tracked_percent"},
      {"truth in the ellipsoid that should hold it in 99 of 100 images, %" + suffix, coverage(all),
       each(scores, coverage), told ? within(97.0, 99.9) : kLargeIsGood,
       name + "coverage99_percent"},
      {"flights with a pose off by 3 cm or 1 degree that its covariance denies" + suffix,
       static_cast<double>(all.silent_wrong), each(scores, &ShapedPipesScore::silent_wrong),
       told ? kNone : kSmallIsGood, name + "silent_wrong"},
      {"flights without a pose at their end" + suffix, static_cast<double>(all.lost),
       each(scores, &ShapedPipesScore::lost), kSmallIsGood, name + "lost"}};
  if (told) {
    measures.push_back({"shapes that were found, %", found(all), each(scores, found), kLargeIsGood,
                        name + "found_percent"});
    measures.push_back({"of their heights, turns and radii, within what should hold 99 of 100, %",
                        values(all), each(scores, values), kLargeIsGood,
                        name + "values_covered99_percent"});
  }
  return measures;
}

}  // namespace

void reproduce_rack_shapes(RackReproduction& run) {
  const RackImageExtent& extent = run.extent.images;
  const auto seeds = seeds_of(run.options, run.options.trials.value_or(extent.shaped));
  for (const World world : {World::kRayCaster, World::kMesh}) {
    const bool rays = world == World::kRayCaster;
    const std::string study = std::to_string(seeds.size()) +
                              " rack files with two pipes of other height, direction and radius, "
                              "deviations stated or not; rendered by " +
                              (rays ? "rays" : "a mesh");
    const auto flights = for_each_seed(run.progress, study, seeds, [&](std::uint64_t seed) {
      return fly_over_shapes(world, extent.shaped_duration, seed);
    });
    std::vector<ShapedPipesScore> told;
    std::vector<ShapedPipesScore> not_told;
    for (const ToldAndNot& flight : flights) {
      told.push_back(flight.told);
      not_told.push_back(flight.not_told);
    }
    const std::string name = rays ? "shapes_rays_" : "shapes_mesh_";
    std::vector<Measure> measures = measures_of(told, true, name + "told_");
    for (Measure& measure : measures_of(not_told, false, name + "not_told_")) {
      measures.push_back(std::move(measure));
    }
    run.rows.add_study(study, measures);
  }
}

}  // namespace pipescout::reproduce
