// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/odometry_study/quantile.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/misplaced_pipes.hpp"
#include "pipescout/rack_study/paper_flight.hpp"
#include "rack_figures.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using rack_study::MisplacedPipesScore;
using rack_study::MisplacedPipesSettings;
using rack_study::World;

constexpr std::array kWorlds{World::kRayCaster, World::kMesh};

/// Images of two renderers that have nothing in common, of pipes that lie elsewhere than the rack
/// file has them.
class RackOffsets {
 public:
  explicit RackOffsets(RackReproduction& run)
      : options_(run.options),
        extent_(run.extent.images),
        rows_(run.rows),
        progress_(run.progress) {}

  void run() {
    misplace("6 cm", 0.06, 0, options_.trials.value_or(extent_.misplaced),
             {"offsets_wrong_silent", "offsets_wrong_converged_percent"}, at_least(95.0));
    misplace("25 cm", 0.25, 0.15, options_.trials.value_or(extent_.misplaced_far),
             {"offsets_far_silent", "offsets_far_converged_percent"}, at_least(80.0));
    figure_8();
    rows_.add_study("Poses over pipes that are not where the rack file has them, both renderers",
                    {{"truth in the ellipsoid that should hold it in 99 of 100 images, %",
                      percent(all_.images_covered, all_.images_with_pose),
                      {},
                      within(97.0, 99.9),
                      "coverage99_percent"}});
  }

 private:
  struct Names {
    std::string silent, converged;
  };

  /// `stated`: what the localisation is told, m; 0: nothing.
  void misplace(const std::string& how_far, double largest_offset, double stated,
                std::size_t trials, const Names& names, const Target& converged) {
    const auto seeds = seeds_of(options_, std::min(trials, extent_.misplaced_places));
    const std::size_t each_place = trials / seeds.size();
    const std::string study = std::to_string(each_place * seeds.size()) +
                              " rack files with each pipe up to " + how_far +
                              " from its place, 3 s each";
    const auto scores = for_each_seed(progress_, study, seeds, [&](std::uint64_t seed) {
      MisplacedPipesSettings settings;
      settings.rack = seed % 4 < 2 ? rack_study::rack_on_beams() : rack_study::parallel_rack(4);
      settings.world = kWorlds[seed % kWorlds.size()];
      settings.largest_offset = largest_offset;
      settings.stated_deviation = stated;
      return rack_study::score_misplaced_pipes(
          rack_study::try_misplaced_pipes(settings, each_place, seed));
    });
    MisplacedPipesScore all;
    for (const MisplacedPipesScore& score : scores) {
      all += score;
    }
    all_ += all;
    rows_.add_study(
        study,
        {{"with a pose off by 3 cm or 1 degree that its covariance denies",
          static_cast<double>(all.silent_wrong), each(scores, &MisplacedPipesScore::silent_wrong),
          kNone, names.silent},
         {"converged after 3 s, %", percent(all.converged, all.trials),
          each(scores, [](const auto& score) { return percent(score.converged, score.trials); }),
          converged, names.converged},
         {"without a pose after 3 s, %", percent(all.lost, all.trials),
          each(scores, [](const auto& score) { return percent(score.lost, score.trials); }),
          kSmallIsGood}});
  }

  /// Figure 8 of the paper: summed distances 15, 35 and 50 cm in the model, 10, 20 and 30 in truth.
  void figure_8() {
    constexpr std::array kFileOffsets{0.0, 0.05, 0.15, 0.20};  // m
    constexpr double kImages = 50;
    const auto seeds = seeds_of(options_, extent_.figure_8);
    const std::string study = "Figure 8 on images, 50 of them";
    const auto errors = for_each_seed(progress_, study, seeds, [&](std::uint64_t seed) {
      MisplacedPipesSettings settings;
      settings.rack = rack_study::parallel_rack(4);
      settings.world = kWorlds[seed % kWorlds.size()];
      settings.stated_deviation = 0.2;
      settings.duration = kImages * rack_study::kFramePeriod;
      settings.start_position = 0.02;
      settings.start_rotation = 0.01;
      const auto trial = rack_study::try_misplaced_pipes(settings, kFileOffsets, seed);
      constexpr double kNone = 1;  // m, said of a flight without a pose at its end
      return trial.frames.back().has_pose ? trial.largest_offset_error : kNone;
    });
    rows_.add_study(study, {{"largest error of an offset, m, median of the flights",
                             odometry_study::quantile(errors, 0.5), errors, at_most(0.005),
                             "fig8_images_offsets_error_m"},
                            {"the same, worst flight", largest(errors), errors, kSmallIsGood,
                             "fig8_images_offsets_worst_m"}});
  }

  const ReproduceOptions& options_;
  const RackImageExtent& extent_;
  FigureRows& rows_;
  StageProgress& progress_;
  MisplacedPipesScore all_;
};

}  // namespace

void reproduce_rack_offsets(RackReproduction& run) {
  RackOffsets(run).run();
}

}  // namespace pipescout::reproduce
